"""Interface of vehicle plug-ins: all that other rooms ask of an autopilot, without naming one.

`autopilot.Autopilot` is the base class and the registry; read it first. Its properties are in `parameters`,
`firmware_tables`, `guidance_profile`, `failsafe` and `returning`. `commands` has MAVLink's numbers,
`energy` the power of a flight, `learned` one vehicle's differences from the simulated one.
"""
