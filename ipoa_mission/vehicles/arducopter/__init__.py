"""ArduCopter 4.x: one folder is the whole plug-in.

`vehicle.py` declares it, with `parameter_table`, `failsafes`, `refusal` and `returning`. `flight_model` predicts times
by `dynamics`; `braking` and `limits` are closed forms. `pilot`, `mock_profile` and `log` are loaded at first use.
"""
