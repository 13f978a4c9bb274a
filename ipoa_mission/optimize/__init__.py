"""Optimizers propose candidates and receive their costs, without knowledge of the problem."""
