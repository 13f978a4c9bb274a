"""ArduCopter 4.x: one folder is the whole plug-in.

`vehicle.py` declares it, with `parameter_table`, `failsafes`, `refusal` and `fence_and_rtl`. `flight_model` predicts
times by `dynamics`; `braking` and `limits` are closed forms. `pilot`, `mock_profile` and `log` are loaded at first use.
"""
