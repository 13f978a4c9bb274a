"""Missions in memory, in files and on the wire.

Read `items` first: it defines `Mission` and `Item`; then `program`, `mission_io` and `stored_mission`.
"""
