"""PX4 on a multicopter, measured on 1.17 and 1.18: one folder is the whole plug-in.

Read `vehicle.py` first.
"""
