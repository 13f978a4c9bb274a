from collections.abc import Iterable

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.parameters import Parameter, Parameters
from ipoa_mission.errors import BadInput, hint_of

#: Meanings that all autopilots define alike: their values are converted.
CONVERTED = frozenset({
    "cruise speed", "climb speed", "descent speed", "acceleration", "vertical acceleration", "acceptance radius",
    "tilt", "landing speed", "return height", "wait before landing",
})  # fmt: skip


def known_names() -> frozenset[str]:
    return frozenset(name for autopilot in registered() for name in autopilot.parameter_names)


def expect_own(names: Iterable[str], autopilot: Autopilot) -> None:
    """Raise BadInput for names of another autopilot; unknown names pass."""
    for name in names:
        other = None if name in autopilot.parameter_names else firmware_of([name])
        if other is not None:
            counterpart = _counterpart(name, other, autopilot)
            words = f"expected a parameter of {autopilot}, not of {other}"
            hint = f"{autopilot} has {counterpart.name} for that" if counterpart else None
            raise BadInput(words, hint=hint, place=name)


def expect_known(names: Iterable[str], autopilot: Autopilot | None = None) -> None:
    """Refuse names that the autopilot, or any if None, does not know; the hint is the closest one."""
    if autopilot is not None:
        expect_own(names, autopilot)
    existing = known_names() if autopilot is None else autopilot.parameter_names
    for name in names:
        if name not in existing:
            words = "expected a parameter that the models know" + (f" of {autopilot}" if autopilot else "")
            raise BadInput(words, place=name, hint=hint_of(name, existing), code="unknown-parameter")


def translated(
    parameters: Parameters, other: Autopilot, autopilot: Autopilot
) -> tuple[dict[str, float], tuple[str, ...]]:
    """Return equal quantities above 0 under their own names, and remarks.

    >>> translated({"RTL_ALT_M": 65.0, "WP_JERK": 2.0}, Autopilot.ARDUPILOT, Autopilot.PX4)[0]
    {'RTL_RETURN_ALT': 65.0}
    """
    values = dict[str, float]()
    left_out = list[str]()
    words = list[str]()
    for name, value in parameters.items():
        ((old, there),) = other.parameter_table.by_old_names({name: value}).items()
        counterpart = _counterpart(name, other, autopilot)
        if name in autopilot.parameter_names:
            values[name] = value
        elif counterpart and counterpart.meaning in CONVERTED and value > 0.0:
            values[counterpart.name] = round(there * other.parameter_table.by_name[old].unit / counterpart.unit, 6)
            words.append(f"{counterpart.name} = {values[counterpart.name]:g} for {name} = {value:g}")
        else:
            left_out.append(name)
    converted = (f"{autopilot} has {', '.join(words)} of {other}",) if words else ()
    return values, (*converted, *((f"left out, of {other} only: {', '.join(left_out)}",) if left_out else ()))


def firmware_of(names: Iterable[str]) -> Autopilot | None:
    return next((autopilot for name in names for autopilot in registered() if name in autopilot.parameter_names), None)


def _counterpart(name: str, other: Autopilot, autopilot: Autopilot) -> Parameter | None:
    (old,) = other.parameter_table.by_old_names({name: 0.0})
    theirs = other.parameter_table.by_name.get(old)
    return autopilot.parameter_table.by_meaning.get(theirs.meaning) if theirs else None
