"""Mission files of any kind: read by what is in them, written by the suffix."""

from pathlib import Path

from ipoa_mission.errors import BadInput
from ipoa_mission.files import read_text
from ipoa_mission.items import Mission
from ipoa_mission.mission.document import parse_document
from ipoa_mission.mission.landing_ground import over_known_ground
from ipoa_mission.mission.parameter_file import beside, read_parameters
from ipoa_mission.mission.plan_file import is_old_mission, parse_old_mission, parse_plan, plan_text, write_plan
from ipoa_mission.mission.waypoints_file import FIRST_LINE, parse_waypoints, waypoints_text, write_waypoints
from ipoa_mission.vehicles.autopilot import Autopilot, default_autopilot
from ipoa_mission.vehicles.known_parameters import firmware_of


def read_mission(path: str | Path, autopilot: Autopilot | None = None) -> Mission:
    """Read a `.plan`, a `.waypoints` or an old `.mission` file, whatever it is called, and NAME.params beside it.

    Where it lands the ground is as high as NAME.json says, if that was written with this very file.

    `autopilot` goes before what a `.plan` says of itself; a `.waypoints` file says nothing: without it, it is for whom
    its parameters are, else for PX4.

    Raises:
        BadInput: the file cannot be read or is neither; the message names the place.
    """
    lying = beside(Path(path))
    parameters = read_parameters(lying) if lying.is_file() else {}
    text = read_text(Path(path))
    mission = _parsed(Path(path), text, autopilot, firmware_of(parameters) or default_autopilot())
    mission = over_known_ground(mission, Path(path), text)
    try:
        return mission.with_parameters(parameters)
    except BadInput as error:
        raise BadInput(f"{lying}: {error}", hint=error.hint) from error


def _parsed(path: Path, text: str, autopilot: Autopilot | None, unsaid: Autopilot) -> Mission:
    beginning = text.lstrip()[: len(FIRST_LINE)]
    if beginning.startswith("{") or (path.suffix.lower() == ".plan" and not beginning.startswith("QGC WPL")):
        document = parse_document(path, text)
        if is_old_mission(document):
            return parse_old_mission(document, autopilot)
        return parse_plan(path, text, autopilot)
    if beginning.startswith("QGC WPL") or path.suffix.lower() == ".waypoints":
        return parse_waypoints(path, text, autopilot or unsaid)
    raise BadInput(f"{path}: expected a .plan file, or a .waypoints file that begins with {FIRST_LINE}")


def write_mission(mission: Mission, path: str | Path, suffix: str | None = None) -> tuple[str, ...]:
    """Write a `.plan` or a `.waypoints` file, by the suffix; returned in words: what it cannot hold, or a reader loses.

    `suffix`, if given, goes before the path's own.

    The mission's parameters go beside it (NAME.params), where `read_mission` finds them.

    Raises:
        BadInput: another suffix, or the mission cannot be put into this format.
    """
    path = Path(path)
    match suffix or path.suffix.lower():
        case ".plan":
            write_plan(mission, path)
            return ()
        case ".waypoints":
            return write_waypoints(mission, path)
        case other:
            raise BadInput(f'{path}: expected a name that ends in .plan or .waypoints, not in "{other}"')


def mission_text(mission: Mission, suffix: str) -> str:
    """The text of a `.plan` or a `.waypoints` file.

    Raises:
        BadInput: the mission cannot be put into this format.
    """
    return plan_text(mission) if suffix == ".plan" else waypoints_text(mission)
