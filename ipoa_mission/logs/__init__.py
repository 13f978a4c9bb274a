"""Read flights from logs, and vehicles learned from them.

Read `flight_log` first. `logged` is the content of any log; `telemetry_log` reads `.tlog`.
"""
