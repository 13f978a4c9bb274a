"""Learn a vehicle's drag, lag, delays and power from logs.

`learn_verb` is the entry. `evidence` reads flights, `witness` measures drag and hover power in each, and `powers` fits
power. `fit` combines all by least squares, and forecasts each flight from the others.
"""
