"""Predict where missions of several vehicles may meet, and set them apart.

`deconflict_verb` is the entry. `fleet` reads the missions, `timed_flight` samples their forecasts in one frame.
`encounters` finds the probability that two flights lose separation. `traffic` lists conflicts, `repairs` finds
departures, holds and heights without any. `contingency_conflicts` finds where an RTL, LAND or hold may meet a flight.
"""
