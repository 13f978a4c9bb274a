"""Parameter files: ArduPilot's (NAME,VALUE or NAME VALUE) and QGroundControl's (ids, NAME, VALUE, type).

Which of the two a line is written in shows in its number of fields, so the file's suffix does not matter.
"""

import math
import re
from pathlib import Path

from ipoa_mission.errors import BadInput
from ipoa_mission.files import read_text
from ipoa_mission.timing import copter_parameters, px4_parameters
from ipoa_mission.vehicle import DEFAULT_PARAMETERS, RENAMED, SINGLE_MAX, Parameters

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,15}", re.ASCII)  # MAVLink's param_id holds sixteen characters
SEPARATOR = re.compile(r"[,\s]+")


def read_parameters(path: Path) -> Parameters:
    """The parameters of a `.parm` or `.params` file by name; comments (`#`) and blank lines are passed over.

    A parameter that stands twice has its last value, as it would have in the vehicle.

    Raises:
        BadInput: the message names the line, as in `quad.parm: line 3: expected a name and a value, not "WPNAV"`.
    """
    found: dict[str, float] = {}
    for number, line in enumerate(read_text(path).splitlines(), start=1):
        text = line.split("#", 1)[0].strip()
        if text:
            name, value = _name_and_value(text, f"{path}: line {number}")
            found[name] = value
    return found


def known_parameters() -> frozenset[str]:
    """The names of all parameters that the models of either autopilot use, old names and new ones."""
    further = (copter_parameters.FURTHER, RENAMED, px4_parameters.FURTHER)
    return frozenset(name for names in (*DEFAULT_PARAMETERS.values(), *further) for name in names)


def _name_and_value(text: str, place: str) -> tuple[str, float]:
    fields = SEPARATOR.split(text)
    match fields:
        case [name, value]:
            pass
        case [vehicle, component, name, value, kind] if (vehicle + component + kind).isdigit():
            pass
        case _:
            raise BadInput(
                f"{place}: expected a name and a value, or vehicle, component, name, value and type, not {text[:60]!r}"
            )
    if not NAME.fullmatch(name):
        raise BadInput(f"{place}: expected a parameter's name of up to 16 letters, digits and _, not {name[:40]!r}")
    try:
        number = float(value)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise BadInput(f"{place}: {name}: expected a number, not {value[:40]!r}")
    if abs(number) > SINGLE_MAX:
        raise BadInput(f"{place}: {name}: expected a number that fits in single precision, not {value[:40]!r}")
    return name.upper(), number
