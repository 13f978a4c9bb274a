import tracemalloc

import numpy as np

from ipoa_mission import Airspace, Bounds, Limits, PathProblem
from ipoa_mission.planning.lattice import lay_lattice
from ipoa_mission.planning.problem import prepare
from ipoa_mission.world.obstacles import Cylinder
from ipoa_mission.world.terrain import Flat

MANY, SIDE = 4000, 1200.0


def test_a_lattice_among_thousands_of_gaps_is_laid_in_little_memory() -> None:
    rng = np.random.default_rng(3)
    masts = tuple(
        Cylinder(f"mast {k}", float(east), float(north), 3.0, 0.0, 60.0)
        for k, (east, north) in enumerate(rng.uniform(0.0, SIDE, (MANY, 2)))
    )
    airspace = Airspace(Bounds((-50.0, -50.0, 0.0), (SIDE + 50.0, SIDE + 50.0, 60.0)), Flat(), masts)
    ends = np.array([[-40.0, -40.0, 30.0], [SIDE + 40.0, SIDE + 40.0, 30.0]])
    problem = prepare(PathProblem(airspace, Limits(obstacle_distance=2.6, height_above_ground=5.0), ends))
    tracemalloc.start()
    lattice = lay_lattice(problem)
    most = tracemalloc.get_traced_memory()[1] / 2**20
    tracemalloc.stop()
    assert np.isfinite(lattice.price).any()
    assert most < 100  # MB; limit 500 for 20,000 obstacles, imports 110
