"""Learn a vehicle's drag, lag, delays and power from logs.

`flight_measurements` computes drag and power of a flight; `fit` combines all by least squares.
"""
