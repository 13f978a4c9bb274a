"""Missions in memory, in files and on the wire.

Read `items` first, then `program`, `mission_io` and `stored_mission`.
"""
