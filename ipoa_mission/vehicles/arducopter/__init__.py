"""ArduCopter 4.x: one folder is the whole plug-in.

`vehicle.py` declares it, with `parameter_table`, `failsafes` and `limits`. `flight_model` predicts times by `dynamics`;
`braking` and `limits` are closed forms. `flight_controller` and `log` load later.
"""
