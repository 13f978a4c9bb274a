"""Plan a flight, write its files, and fly it on a vehicle.

Read `flight` first: `plan_flight` plans and checks, `Flight.write` writes the files. `procedure` uploads and flies them
after the checks of `preflight`. `post_flight` compares the record.
"""
