"""Named tuples as numpy records, for long tuples in compiled code."""

from functools import cache
from operator import attrgetter
from typing import Annotated, Any, get_args, get_origin, get_type_hints

import numpy as np

_PLAIN = {float: np.float64, int: np.int64, bool: np.bool_}


@cache
def record_type(kind: type) -> np.dtype[np.void]:
    """Return a class's record type; `Annotated[list[X], n]` has length n."""
    return np.dtype([(name, *_field(hint)) for name, hint in get_type_hints(kind, include_extras=True).items()])


def _field(hint: Any) -> tuple[Any, ...]:
    if get_origin(hint) is Annotated:
        several, count = get_args(hint)
        return *_field(*get_args(several)), (count,)
    return (_PLAIN.get(hint) or record_type(hint),)


def records(values: Any, kind: type) -> Any:
    """Return named tuples, or objects with plain fields, as records."""
    made = record_type(kind)
    rows = list(values) if issubclass(kind, tuple) else list(map(attrgetter(*made.names or ()), values))
    return np.array(rows, made)
