"""Forecast a mission's flight: path, times, clearance, energy, and how it can end.

Read `forecast` first: a `Forecast` has each part. `itinerary` unrolls the mission, `timing` predicts it, `deviation`
bounds how far flights stray, `contingency` has RTL and LAND. `conformance` compares a flight with its forecast.
"""
