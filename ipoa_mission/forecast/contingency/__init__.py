"""Compute the contingencies of a flight, in this order.

`stopping_points`: where and when an aborted flight stops. `return_routes`: the kind and route of its return.
`contingency_paths`: the possible paths, and their distances to obstacles and ground. `shortfalls`: those too near, and
a clear return altitude. `grades`: how surely a contingency is clear. `energy_budget`: energy by item, and the point of
no return. `contingencies`: all of it in rows by time. `contingencies_now`: the rows at the present time of a flight.
"""
