"""Set missions of several vehicles apart: `deconflict_verb`.

`fleet` samples forecasts, `encounters` finds conflicts, `repairs` a timetable. `contingency_conflicts` finds where an
RTL, LAND or hold may meet another's flight.
"""
