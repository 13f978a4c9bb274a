"""Vehicle plug-ins, found by the entry points `ipoa_mission.vehicles`.

Read `arducopter/vehicle.py` first: it declares all that other rooms ask, and names its parts. `flight_model` predicts
times by `dynamics`, `pilot` flies the same dynamics in the built-in autopilot, `log` reads the firmware's logs.
`limits` turns parameters into motion limits. PX4's return is in `limits.Px4Return` and `vehicle.return_route`.
"""
