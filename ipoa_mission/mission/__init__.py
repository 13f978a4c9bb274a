"""Missions in memory, in files and on the wire.

Read `items.py` first: it defines `Mission` and `Item`. `program` has their order and places. `mission_io` reads and
writes files: `plan_file` reads those of QGroundControl, `written_files` writes. `stored_mission` converts
to and from the wire.
"""
