"""What a test expects of an error: its code, its place, and what its message must name."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from ipoa_mission.errors import MissionError


@contextmanager
def refused(code: str, place: str = "", *names: str) -> Iterator[pytest.ExceptionInfo[MissionError]]:
    """Expect an error with this code, whose place ends in `place`, and whose message has each of the `names`.

    Names are figures, names of things, parameters and options: no prose.
    """
    with pytest.raises(MissionError) as caught:
        yield caught
    error = caught.value
    assert error.code == code, f"{error.code}: {error}"
    assert (error.place or "").endswith(place), f"{error.place}: {error}"
    assert not [name for name in names if name not in f"{error}"], f"{names}: {error}"
