"""Cost of a path, and the search for the best one.

Read `planner` first: `lattice` guesses, an optimizer searches, `polish` descends, `proof` proves. `problem` prepares a
task for them with the paper's cost, `obstruction` explains why there is no path.
`planner.sketch_path` plans without a search, for the studio.
"""
