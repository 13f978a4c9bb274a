"""Compute how a flight can end: RTL, LAND, SmartRTL and hold at each second.

Read `contingencies` first; `contingency_paths` has paths and distances. The time of an RTL on PX4: its
`predict_contingency`, `predict_abort` of the vehicle's `flight_model.py`, `dynamics/navigator.return_orders`.
"""
