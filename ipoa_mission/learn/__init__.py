"""Learn a vehicle's drag, lag, delays and power from logs.

`learn_verb` is the entry. `evidence` reads flights, `flight_measurements` computes drag and hover power, `powers` fits
power. `fit` combines all by least squares, and forecasts each flight from the others.
"""
