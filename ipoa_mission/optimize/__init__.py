"""Optimizers propose candidates and receive their costs, without knowledge of the problem.

Read `search.py` first: `minimize` runs any of them. `ipoa` and `poa` are the paper's.
"""
