"""Predict where missions of several vehicles may meet, and set them apart: `deconflict_verb`.

`fleet` samples the missions' forecasts in one frame. `encounters` finds conflicts and their probability, `repairs` a
timetable without any. `contingency_conflicts` finds where an RTL, LAND or hold may meet another's flight.
"""
