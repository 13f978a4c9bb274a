"""Plan a flight, write its files, and fly it on a vehicle.

Read `flight` first. `procedure` uploads and flies after the checks of `preflight`; `post_flight` compares the record.
"""
