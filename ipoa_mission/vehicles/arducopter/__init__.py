"""ArduCopter 4.x: one folder is the whole plug-in.

`vehicle.py` declares it, with `limits` and `failsafes`. `flight_controller` and `log` load later.
"""
