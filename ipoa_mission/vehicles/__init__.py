"""Vehicle plug-ins, found by the entry points `ipoa_mission.vehicles`.

Read `arducopter/vehicle.py` first: it declares all that other rooms ask, and names its parts. `flight_model` predicts
times by `dynamics`, `flight_controller` flies the same dynamics in the built-in autopilot, `log` reads logs.
`limits` turns parameters into motion limits.
"""
