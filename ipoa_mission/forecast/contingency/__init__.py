"""Compute how a flight can end: RTL, LAND, SmartRTL and hold at each second.

Read `contingencies` first: rows by time. `contingency_paths` has the paths and their distances. The time of an RTL on
PX4: `energy_budget.predict_contingency`, then `vehicles/px4_multicopter/flight_model.py` (`predict_abort`), then its
`dynamics/navigator.py` (`way_home`).
"""
