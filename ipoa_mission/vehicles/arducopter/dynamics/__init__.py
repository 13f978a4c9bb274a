"""Dynamics of ArduCopter 4.x in steps of 0.02 s, for estimates and the built-in autopilot.

`copter.Copter` flies legs; read it first. `legs` plans a leg, with the S-curves of `scurve`. `steps` flies it, as
Python or compiled. `procedures` has the legs of LAND, RTL, LOITER_TURNS and LOITER_TO_ALT.
"""
