import math

import numpy as np
from numpy.typing import NDArray


def levy_factor(beta: float, shape: tuple[int, ...], rng: np.random.Generator) -> NDArray[np.float64]:
    """Return factors s by Mantegna's algorithm, eqs. (25) and (26)."""
    sigma_u = (
        math.gamma(1 + beta)
        * math.sin(math.pi * beta / 2)
        / (math.gamma((1 + beta) / 2) * beta * 2 ** ((beta - 1) / 2))
    ) ** (1 / beta)
    u, v = rng.standard_normal((2, *shape))
    factor: NDArray[np.float64] = sigma_u * u / np.abs(v) ** (1 / beta)
    return factor
