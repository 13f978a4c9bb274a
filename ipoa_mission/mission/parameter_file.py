"""Parameter files: ArduPilot's (NAME,VALUE or NAME VALUE) and QGroundControl's (ids, NAME, VALUE, type).

Which of the two a line is written in shows in its number of fields, so the file's suffix does not matter. A mission
file holds no parameters: those of a mission stand beside it, in QGroundControl's format.
"""

import math
import re
from collections.abc import Mapping
from pathlib import Path

from ipoa_mission.errors import BadInput
from ipoa_mission.files import read_text, write_together
from ipoa_mission.mission.items import Mission
from ipoa_mission.vehicles.parameters import REAL32, SINGLE_MAX, Parameters

FIRST_LINE = "# Parameters of the vehicle that {} was made for"
COLUMNS = "# Vehicle-Id Component-Id Name Value Type"
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,15}", re.ASCII)  # MAVLink's param_id holds sixteen characters
SEPARATOR = re.compile(r"[,\s]+")


def read_parameters(path: str | Path) -> Parameters:
    """The parameters of a `.parm` or `.params` file by name; comments (`#`) and blank lines are passed over.

    A parameter that stands twice has its last value, as it would have in the vehicle.

    Raises:
        BadInput: the message names the line, as in `quad.parm: line 3: expected a name and a value, not "WPNAV"`.
    """
    parameters: dict[str, float] = {}
    for number, line in enumerate(read_text(Path(path)).splitlines(), start=1):
        text = line.split("#", 1)[0].strip()
        if text:
            name, value = _name_and_value(text, f"{path}: line {number}")
            parameters[name] = value
    return parameters


def beside(path: Path) -> Path:
    """Where the parameters of the mission in a file stand."""
    return path.with_suffix(".params")


def parameters_beside(mission: Mission, path: Path) -> dict[Path, str]:
    """The file with the mission's parameters that belongs beside `path`, and its text; none where it has none.

    Raises:
        BadInput: the mission has parameters, and in their place stands a file that was not written here.
    """
    target = beside(path)
    if not mission.parameters:
        return {}
    if target.exists() and not _is_ours(target):
        raise BadInput(
            "expected no file of somebody else's, where the mission's parameters belong",
            hint="move it, or write the mission under another name",
            code="already-there",
            place=target,
        )
    lines = (  # with its type: QGroundControl does not load a parameter of another than the vehicle's
        f"1\t1\t{name}\t{_number(value)}\t{mission.autopilot.book.types.get(name, REAL32)}"
        for name, value in mission.parameters.items()
    )
    return {target: "\n".join([FIRST_LINE.format(path.stem), COLUMNS, *lines]) + "\n"}


def write_with_parameters(mission: Mission, contents: Mapping[Path, str]) -> None:
    """Write files of a mission and its parameters beside them, all or none.

    Where it has no parameters, what was written there before is removed.

    Raises:
        BadInput: a file cannot be written, or in the parameters' place stands one that was not written here.
    """
    path = next(iter(contents))
    write_together({**contents, **parameters_beside(mission, path)})
    if not mission.parameters and _is_ours(beside(path)):
        beside(path).unlink()


def _is_ours(target: Path) -> bool:
    return target.exists() and read_text(target).startswith(FIRST_LINE.partition("{}")[0])


def _name_and_value(text: str, place: str) -> tuple[str, float]:
    fields = SEPARATOR.split(text)
    match fields:
        case [name, value]:
            pass
        case [vehicle, component, name, value, kind] if (vehicle + component + kind).isdigit():
            pass
        case _:
            raise BadInput(
                f"expected a name and a value, or vehicle, component, name, value and type, not {text[:60]!r}",
                place=place,
            )
    if not NAME.fullmatch(name):
        raise BadInput(f"expected a parameter's name of up to 16 letters, digits and _, not {name[:40]!r}", place=place)
    try:
        number = float(value)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise BadInput(f"expected a number, not {value[:40]!r}", place=f"{place}: {name}")
    if abs(number) > SINGLE_MAX:
        raise BadInput(f"expected a number that fits in single precision, not {value[:40]!r}", place=f"{place}: {name}")
    return name.upper(), number


def _number(value: float) -> str:
    return f"{value:.0f}" if value == int(value) else repr(float(value))
