"""Measure the paper's tables and figures again (Biomimetics 2024, 9, 647), next to the printed values.

Read `reproduce.py` first: `ITEMS` lists tables and figures. `runs` defines, runs and stores trials.
`rivals` are the paper's other algorithms.
"""
