"""Compute how a flight can end: RTL, LAND, SmartRTL and hold at each second.

Read `contingencies` first; `contingency_paths` has paths and distances. On PX4 an ordered RTL is timed by
`predict_contingency` of `flight_model.py`, an RTL item by `predicted` and `_Navigator.visit`; both by `return_orders`.
"""
