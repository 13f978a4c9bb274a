"""Mean ranks in a sentence: the Friedman test over functions or maps, and whom it tells from one of the treatments."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.experiments.statistics import friedman, post_hoc


def ranking(names: Sequence[str], costs: NDArray[np.float64], control: str = "ipoa") -> str:
    """What the test says of `costs` (blocks, names), and how the others compare with `control` after it."""
    test = friedman(costs)
    own = names.index(control)
    p = post_hoc(test, own)
    signs = {
        name: "=" if p[i] >= 0.05 else "+" if test.mean_ranks[own] < test.mean_ranks[i] else "-"
        for i, name in enumerate(names)
        if i != own
    }
    in_order = sorted(zip(test.mean_ranks, names, p, strict=True))
    return (
        ", ".join(f"{name} {rank:.2f}" for rank, name, _ in in_order)
        + f" (Friedman p = {test.p:.1e}; after it {control} against "
        + ", ".join(f"{name} {q:.2g} ({signs[name]})" for _, name, q in in_order if name != control)
        + ", Holm)"
    )
