"""Dynamics of PX4's multicopter, for estimates and the built-in autopilot.

`navigator` turns items into motions, `flight.fly` flies them, as Python or compiled; read it first. `step` is one step:
`guidance` for the velocity setpoint, then trajectory, position controller and `body`. `state` has the types.
"""
