"""Bound the distance of flown from predicted paths, and compute the clearance that remains.

`promise` has it by limit: read it first. `law` is the measured distribution, `approach` the chance to come too near to
an obstacle, `kept_limits` the rest. `room` enlarges obstacles while a path is planned.
"""
