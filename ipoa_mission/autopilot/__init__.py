"""Interface of vehicle plug-ins: all that other rooms ask of an autopilot, without naming one.

Read `autopilot.Autopilot` first: the base class and the registry. Its properties are in `parameters`,
`firmware_tables`, `guidance_profile`, `failsafe` and `returning`.
"""
