"""Read flights from logs.

Read `flight_log` first. `logged` is the content of any log; `telemetry_log` reads `.tlog`.
"""
