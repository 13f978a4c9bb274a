"""Learn a vehicle's drag, lag, delays and power from logs.

`learn_verb` is the entry. `flight_measurements` computes drag and power of a flight. `fit` reads flights, combines all
by least squares, and forecasts each flight from the others.
"""
