from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from ipoa_mission.errors import MissionError


@contextmanager
def refuses(
    code: str, place: str = "", *names: str, kind: type[MissionError] = MissionError, **facts: object
) -> Iterator[pytest.ExceptionInfo[Any]]:
    """Expect an error with this code, whose place ends in `place`, and whose message has each of the `names`.

    `names` are figures, names of things, parameters and options, no prose of ours; `facts` are attributes, or `known`.
    """
    with pytest.raises(kind) as caught:
        yield caught
    error = caught.value
    assert error.code == code, f"{error.code}: {error}"
    assert (error.place or "").endswith(place), f"{error.place}: {error}"
    assert {name: getattr(error, name, error.known.get(name)) for name in facts} == facts
    assert not [name for name in names if name not in f"{error}"], f"{names}: {error}"
