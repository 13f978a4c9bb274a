"""Predict the time of a mission offline; `estimate` has it by item.

`flight_model` is the interface of each autopilot. `track` is a path with its times.
"""
