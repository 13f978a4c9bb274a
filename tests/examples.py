"""How many examples a property is tried on, where they are not as many as usual."""

from hypothesis import settings

USUAL = 50


def examples(usually: int) -> int:
    """So many, and as many times more as `--hypothesis-profile` wants."""
    wanted = settings.default
    assert wanted is not None
    return max(1, usually * wanted.max_examples // USUAL)
