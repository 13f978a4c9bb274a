"""Bound the distance of flown from predicted paths, and compute the clearance that remains.

`clearance_guarantee` has it by limit: read it first. `law` is the measured distribution, `proximity` the probability to
come too near to an obstacle, `kept_limits` the rest.
"""
