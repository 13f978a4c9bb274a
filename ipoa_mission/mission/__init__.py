"""Missions in memory, in files and on the wire.

Read `items.py` first: it defines `Mission` and `Item`. `program` has their order and places. `mission_io` reads and
writes files: `plan_file` those of QGroundControl, `waypoints_file` the others, `parameter_file` the parameters.
`stored_mission` converts to and from the wire.
"""
