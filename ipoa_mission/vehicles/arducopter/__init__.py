"""ArduCopter 4.x: one folder is the whole plug-in.

`vehicle.py` declares it, with `limits` and `failsafes`. `braking` and `limits` are closed forms. `flight_controller`
and `log` load later.
"""
