"""Find the course of a mission's flight.

`program` has the order of items, and the place of each. `itinerary` unrolls them, `flown_legs` makes legs of them, with
the curves of `copter_curves`; `unknown` has the items that no forecast covers.
"""
