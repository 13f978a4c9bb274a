"""Parameter files: NAME,VALUE or NAME VALUE of ArduPilot, ids, NAME, VALUE, type of QGroundControl."""

import math
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple, TypeAlias

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.known_parameters import firmware_of, known_names
from ipoa_mission.autopilot.parameters import REAL32, SINGLE_MAX, Parameters
from ipoa_mission.errors import BadInput
from ipoa_mission.files import read_text
from ipoa_mission.mission.items import Mission
from ipoa_mission.unread import Unread, gathered

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,15}", re.ASCII)  # of MAVLink's param_id
NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?|[-+]?nan", re.ASCII | re.IGNORECASE)
PARAMETERS_HEADER = "# Parameters of the vehicle that {} was made for"
UNUSUAL_RATIO = 25.0  # ratio to the default that suggests another unit

_Owner: TypeAlias = tuple[str, str]  # vehicle, component


class ParameterFile(NamedTuple):
    parameters: Parameters
    unread: tuple[Unread, ...] = ()


class _Row(NamedTuple):
    line: int
    name: str
    value: float
    owner: _Owner | None


def read_parameter_file(path: str | Path) -> ParameterFile:
    text = read_text(Path(path))
    lines = ((n, line.split("#", 1)[0].strip()) for n, line in enumerate(text.splitlines(), start=1))
    rows = [_row(content, n, f"{path}: line {n}") for n, content in lines if content]
    owners = [row.owner for row in rows]
    autopilots = (owner for owner in owners if owner is not None and owner[1] == "1")  # MAV_COMP_ID_AUTOPILOT1
    owner = next(autopilots, owners[0] if owners else None)
    parameters = {name: row.value for name, row in _in_force(rows, owner).items()}
    return ParameterFile(parameters, gathered(_unread(Path(path).name, text, rows, owner)))


def parameter_path(path: Path) -> Path:
    return path.with_suffix(".params")


def parameter_contents(mission: Mission, path: Path) -> dict[Path, str | None]:
    """Return the file next to `path`; None: remove ours. Raise BadInput for another's."""
    target = parameter_path(path)
    is_ours = target.exists() and read_text(target).startswith(PARAMETERS_HEADER.partition("{}")[0])
    if not mission.parameters:
        return {target: None} if is_ours else {}
    if target.exists() and not is_ours:
        words = "expected a free name for the mission's parameters, not a file of another origin"
        hint = "move it, or write the mission under another name"
        raise BadInput(words, hint=hint, code="already-there", place=target)
    lines = [PARAMETERS_HEADER.format(path.stem), "# Vehicle-Id Component-Id Name Value Type"]
    kinds = mission.autopilot.parameter_table.kinds
    for name, value in mission.parameters.items():
        number = f"{value:.0f}" if float(value).is_integer() else repr(float(value))
        kind = kinds.get(name, REAL32)  # QGroundControl requires the vehicle's own type
        lines.append(f"1\t1\t{name}\t{number}\t{kind}")
        _row(lines[-1], len(lines), str(target))  # refuses what `read_parameter_file` would
    return {target: "\n".join(lines) + "\n"}


def _in_force(rows: list[_Row], owner: _Owner | None) -> dict[str, _Row]:
    return {row.name: row for row in rows if row.owner in (owner, None)}


def _row(text: str, line: int, place: str) -> _Row:
    owner = None
    is_whole = False
    match re.split(r"[,\s]+", text):
        case [name, value]:
            pass
        case [vehicle, component, name, value, kind] if (vehicle + component + kind).isdecimal():
            owner = (vehicle, component)
            is_whole = int(kind) not in (9, 10)  # MAV_PARAM_TYPE: floats
            if not 1 <= int(kind) <= 10:
                raise BadInput(f"expected a MAV_PARAM_TYPE from 1 to 10, not {kind}", place=f"{place}: {name}")
        case _:
            words = f"expected a name and a value, or vehicle, component, name, value and type, not {text[:60]!r}"
            raise BadInput(words, place=place)
    if not NAME.fullmatch(name):
        raise BadInput(f"expected a parameter's name of up to 16 letters, digits and _, not {name[:40]!r}", place=place)
    place = f"{place}: {name}"
    if not NUMBER.fullmatch(value) or not math.isfinite(number := float(value)):
        raise BadInput(f"expected a number, not {value[:40]!r}", place=place)
    if abs(number) > SINGLE_MAX:
        raise BadInput(f"expected a number that fits in single precision, not {value[:40]!r}", place=place)
    if is_whole and not number.is_integer():
        raise BadInput(f"expected a whole number, as its type is, not {value[:40]!r}", place=place)
    return _Row(line, name.upper(), number, owner)


def _unread(file: str, text: str, rows: list[_Row], owner: _Owner | None) -> Iterator[Unread]:
    in_force = _in_force(rows, owner)
    for row in rows:
        if row.owner not in (owner, None):
            source = "vehicle {}, component {}".format(*row.owner or ())
            yield Unread(file, "parameters of another vehicle or component", f"line {row.line}: {source}", row.name)
        elif row.value != in_force[row.name].value:
            words = "values of parameters that a later line overrides"
            yield Unread(file, words, f"line {row.line}: {row.name}", f"{row.value:g}")
    for autopilot in registered():
        yield from _doubtful(file, in_force, autopilot)
    known = known_names()
    unused = [row for name, row in in_force.items() if name not in known]
    flies = firmware_of(in_force)
    if len(unused) < 100:  # more: a vehicle's complete list
        yield from (Unread(file, "parameters that no model uses", f"line {row.line}", row.name) for row in unused)
    elif flies is not None:
        there = flies.parameter_table.by_old_names(dict.fromkeys(in_force, 0.0))
        for name in sorted(flies.parameter_table.moving.keys() - there.keys()):
            yield Unread(file, "parameters missing in the list: their defaults apply", name)
    header = re.search(r"^#\s*Vehicle:\s*(.*(?:wing|plane|vtol|rover|boat|sub|ground|heli|ship).*)$", text, re.I | re.M)
    if header is not None:
        yield Unread(file, "the vehicle's class: taken as multicopter", "header", header[1].strip())
    if not rows:
        yield Unread(file, "parameters: the file has none", "the file")
    elif not text.endswith(("\n", "\r")) and not (rows[-1].owner and rows[-1].line == len(text.splitlines())):
        yield Unread(file, "the rest, if any: the last line has no line end", f"line {rows[-1].line}", rows[-1].name)


def _doubtful(file: str, in_force: Mapping[str, _Row], autopilot: Autopilot) -> Iterator[Unread]:
    table = autopilot.parameter_table
    for name, (old, unit) in table.renamed.items():
        newer = in_force.get(name)
        older = in_force.get(old)
        if newer and older and not math.isclose(newer.value * unit, older.value, rel_tol=1e-5):
            yield Unread(file, f"old name next to {name}", f"line {older.line}: {old}", f"{older.value:g}")
        default = abs(table.moving.get(old, 0.0))
        for row, factor in ((newer, unit), (older, 1.0)):
            ratio = abs(row.value) * factor / default if row and default and unit != 1.0 else 0.0
            if row and ratio and not 1 / UNUSUAL_RATIO < ratio < UNUSUAL_RATIO:
                words = f"the unit of {row.name}, taken as documented: {ratio:.3g} times the default"
                yield Unread(file, words, f"line {row.line}", f"{row.value:g}")
    for meaning in ("cruise speed", "climb speed", "descent speed"):
        speed = table.by_meaning[meaning]
        row = in_force.get(speed.name)
        if row and speed.unit == 1.0 and row.value > table.fastest:
            words = f"the unit of {row.name}, taken as m/s: beyond {table.fastest:g} m/s"
            yield Unread(file, words, f"line {row.line}", f"{row.value:g}")
    for row in filter(None, map(in_force.get, table.steered_by)):
        if row.value > 0.0:
            words = f"{row.name}, which lets the vehicle leave its path for fences and what it senses"
            yield Unread(file, words, f"line {row.line}", f"{row.value:g}")
