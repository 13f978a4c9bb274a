"""A local page to draw, plan, prove, fly and watch a flight.

Read `session` first: it serves one file. `plan_worker` and `flight_worker` do its jobs.
"""
