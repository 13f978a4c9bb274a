"""The built-in autopilot, which answers MAVLink and flies as PX4 or ArduPilot does.

Read `built_in_autopilot` first: it joins mission protocol, commands, telemetry, files and flight of one vehicle. `fly`
runs on a virtual clock, `station.Server` on a real one.
"""
