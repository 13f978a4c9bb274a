"""PX4 on a multicopter, measured on 1.17 and 1.18: one folder is the whole plug-in.

Read `vehicle.py` first. `flight_model` predicts times by `dynamics`, with the motion limits of `limits`.
"""
