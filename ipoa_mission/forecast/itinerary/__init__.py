"""Find the course of a mission's flight.

`itinerary` unrolls the program of a mission. `flown_legs` makes legs of it, with the curves of `copter_curves`.
"""
