"""The MAVLink client: find a vehicle, exchange missions with it, fly and watch it.

`connect.connect` returns a `vehicle.Vehicle`, whose methods run dialogues. Read `dialogue` first; docs/link.md has the
layers.
Safety: a list counts as stored only after it was read back, and the same list is proved again before the arming.
`vehicle` alone imports `checks`: a program that calls `Vehicle.upload` itself must not send an unsafe mission.
"""
