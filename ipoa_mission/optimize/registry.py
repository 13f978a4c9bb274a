"""The optimizers by name, and how one is made from a name and settings that a user wrote."""

from collections.abc import Mapping
from dataclasses import fields
from difflib import get_close_matches
from typing import get_type_hints

from ipoa_mission.errors import BadInput
from ipoa_mission.optimize.adaptive_pelican import AdaptivePelican
from ipoa_mission.optimize.dbo import DBO
from ipoa_mission.optimize.hho import HHO
from ipoa_mission.optimize.ipoa import IPOA
from ipoa_mission.optimize.mpoa import MPOA
from ipoa_mission.optimize.poa import POA
from ipoa_mission.optimize.search import Optimizer
from ipoa_mission.optimize.settings import check_setting
from ipoa_mission.optimize.ssa import SSA

OPTIMIZERS: dict[str, type[Optimizer]] = {
    "ipoa": IPOA,
    "dbo": DBO,
    "poa": POA,
    "ssa": SSA,
    "mpoa": MPOA,
    "hho": HHO,
    "adaptive-pelican": AdaptivePelican,
}


def build_optimizer(name: str, settings: Mapping[str, object], place: str = "optimizer") -> Optimizer:
    """The optimizer called `name` with `settings`; what is not set keeps its default.

    Raises:
        BadInput: no such optimizer, no such setting, or a value it cannot have; the message begins with `place`.
    """
    if name not in OPTIMIZERS:
        raise BadInput(f"{place}.name: expected {_one_of(OPTIMIZERS)}, not {name!r}{_did_you_mean(name, OPTIMIZERS)}")
    kind = OPTIMIZERS[name]
    types = get_type_hints(kind, include_extras=True)
    names = [field.name for field in fields(kind)]  # type: ignore[arg-type]
    for key in settings:
        if key not in names:
            raise BadInput(
                f"{place}.{key}: {name} has no such setting; it has {', '.join(names)}{_did_you_mean(key, names)}"
            )
    return kind(**{key: check_setting(f"{place}.{key}", types[key], value) for key, value in settings.items()})


def _one_of(names: Mapping[str, object]) -> str:
    *others, last = names
    return f"{', '.join(others)} or {last}"


def _did_you_mean(word: str, candidates: Mapping[str, object] | list[str]) -> str:
    close = get_close_matches(word.lower(), list(candidates), n=1)
    return f" (did you mean {close[0]!r}?)" if close else ""
