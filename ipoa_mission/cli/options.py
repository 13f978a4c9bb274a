"""Options that several verbs share, each said once."""

import math
from dataclasses import replace
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from ipoa_mission.autopilots.vehicle import SINGLE_MAX, Autopilot
from ipoa_mission.cli.packed import or_packed
from ipoa_mission.errors import BadInput

if TYPE_CHECKING:
    from ipoa_mission.wind import Wind

#: Headings under which `--help` gathers options.
ON_THE_LINK = "The link"
BAD_LINK = "A worse link than there is, to see what happens"


class Backend(StrEnum):
    """Who speaks MAVLink for us."""

    BUILTIN = "builtin"
    MAVSDK = "mavsdk"


class Planner(StrEnum):
    """How a path is sought."""

    DEFAULT = "default"
    PAPER = "paper"


class Optimizer(StrEnum):
    """Who seeks: the names of `optimize.registry`."""

    IPOA = "ipoa"
    DBO = "dbo"
    POA = "poa"
    SSA = "ssa"
    MPOA = "mpoa"
    HHO = "hho"
    ADAPTIVE_PELICAN = "adaptive-pelican"


def expect_scenario(path: Path) -> Path:
    """The scenario's file, or one that is packed; BadInput for a mission file."""
    if path.suffix.lower() in (".plan", ".waypoints"):
        raise BadInput(
            f"{path}: expected a scenario (.toml), not a mission", hint=f"fly takes missions: ipoa-mission fly {path}"
        )
    return or_packed(path)


def expect_mission(path: Path) -> Path:
    """Raise BadInput for a scenario where a mission file is expected."""
    if path.suffix.lower() == ".toml":
        raise BadInput(
            f"{path}: expected a mission (.plan, .waypoints), not a scenario", hint=f"first: ipoa-mission plan {path}"
        )
    return path


ScenarioArgument: TypeAlias = Annotated[
    Path, typer.Argument(metavar="SCENARIO", callback=expect_scenario, help="Scenario file (TOML), or `campus`.")
]
FileArgument: TypeAlias = Annotated[
    Path, typer.Argument(metavar="FILE", callback=expect_mission, help="Mission file: .plan or .waypoints.")
]
FileOrScenario: TypeAlias = Annotated[
    Path,
    typer.Argument(
        metavar="SCENARIO|FILE",
        callback=or_packed,
        help="Scenario (.toml, or `campus`) to plan first, or mission (.plan, .waypoints).",
    ),
]
ScenarioOption: TypeAlias = Annotated[
    Path | None,
    typer.Option(
        "--scenario",
        metavar="SCENARIO",
        help="The world it flies in: terrain, obstacles, wind, and the vehicle's parameters.",
    ),
]
ForceOption: TypeAlias = Annotated[
    bool,
    typer.Option("--force", metavar="", help="Write over files that are there, also those not written by a plan."),
]
OutOption: TypeAlias = Annotated[
    Path, typer.Option("--out", metavar="DIR", help="Folder for the files; made if absent.")
]
SeedOption: TypeAlias = Annotated[int, typer.Option("--seed", metavar="N", min=0, help="Same seed, same bytes.")]
OptimizerOption: TypeAlias = Annotated[
    Optimizer | None, typer.Option("--optimizer", help="Search by this optimizer instead of the scenario's.")
]
PlannerOption: TypeAlias = Annotated[
    Planner | None, typer.Option("--planner", help="How to seek: paper is the algorithm as printed.")
]
PolishOption: TypeAlias = Annotated[
    bool, typer.Option("--polish/--no-polish", metavar="", help="Refine the best paths found.")
]
AutopilotOption: TypeAlias = Annotated[
    Autopilot | None,
    typer.Option("--autopilot", help="Firmware that flies it; left out, what the file says (.waypoints: px4)."),
]
ParameterOption: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        "--param", metavar="NAME=VALUE", help="A parameter that the autopilot has, not its default. Repeatable."
    ),
]
ParameterFileOption: TypeAlias = Annotated[
    Path | None,
    typer.Option("--param-file", metavar="FILE", help="A file of such parameters: .parm or .params."),
]
WindOption: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--wind",
        metavar="M/S@DEG",
        help="A steady wind: its speed, and where it blows from, like 6@270 (from the west).",
    ),
]
WindProfileOption: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--wind-profile",
        metavar="EXPONENT@M",
        help="How the wind grows with height: by a power law up to the gradient height, like 0.14@60.",
    ),
]
LearnedOption: TypeAlias = Annotated[
    Path | None,
    typer.Option("--vehicle", metavar="FILE", help="A vehicle that `learn` has written: drag, lag, delays, power."),
]
LinkOption: TypeAlias = Annotated[
    str,
    typer.Option(
        "--link",
        metavar="URL",
        rich_help_panel=ON_THE_LINK,
        help="udpin:HOST:PORT, udpout:HOST:PORT, tcp:HOST:PORT, serial:DEVICE:BAUD.",
    ),
]
VehicleOption: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--link",
        metavar="URL",
        rich_help_panel=ON_THE_LINK,
        help="A real vehicle, like udpin:127.0.0.1:14550; left out, the built-in autopilot.",
    ),
]
SystemOption: TypeAlias = Annotated[
    int | None,
    typer.Option(
        "--system",
        metavar="N",
        min=1,
        max=255,
        rich_help_panel=ON_THE_LINK,
        help="The vehicle's system id, if there are several.",
    ),
]
LogOption: TypeAlias = Annotated[
    Path | None,
    typer.Option(
        "--log",
        metavar="FILE",
        rich_help_panel=ON_THE_LINK,
        help="Where every frame goes (.tlog); left out, beside the mission's files.",
    ),
]
TimeoutOption: TypeAlias = Annotated[
    float | None,
    typer.Option(
        "--timeout",
        metavar="S",
        min=1.0,
        rich_help_panel=ON_THE_LINK,
        help="Give up if it is not done, or the flight not begun, within so many seconds; left out, an hour.",
    ),
]
KeyOption: TypeAlias = Annotated[
    Path | None,
    typer.Option(
        "--key",
        metavar="FILE",
        envvar="IPOA_MISSION_KEY",
        rich_help_panel=ON_THE_LINK,
        help="Sign MAVLink with the key in this file; or set IPOA_MISSION_PASSPHRASE.",
    ),
]
BackendOption: TypeAlias = Annotated[
    Backend, typer.Option("--backend", rich_help_panel=ON_THE_LINK, help="Who speaks MAVLink for us.")
]
AnywayOption: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--anyway",
        metavar="",
        rich_help_panel=ON_THE_LINK,
        help="Do it although a check fails: mission, home, firmware, another vehicle with its id.",
    ),
]
FromOption: TypeAlias = Annotated[
    int,
    typer.Option(
        "--from",
        metavar="N",
        min=1,
        rich_help_panel=ON_THE_LINK,
        help="Begin at item N instead of the first, as `show` numbers it; the way there is checked.",
    ),
]
SetParametersOption: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--set-params",
        metavar="",
        rich_help_panel=ON_THE_LINK,
        help="Write the scenario's parameters, and those of --param, that the vehicle has otherwise.",
    ),
]
LossOption: TypeAlias = Annotated[
    float,
    typer.Option("--loss", metavar="SHARE", min=0, max=1, rich_help_panel=BAD_LINK, help="Of frames that get lost."),
]
DuplicateOption: TypeAlias = Annotated[
    float,
    typer.Option(
        "--duplicate", metavar="SHARE", min=0, max=1, rich_help_panel=BAD_LINK, help="Of frames that come twice."
    ),
]
DelayOption: TypeAlias = Annotated[
    float, typer.Option("--delay", metavar="S", min=0, rich_help_panel=BAD_LINK, help="Seconds that a frame takes.")
]
ReorderOption: TypeAlias = Annotated[
    float,
    typer.Option("--reorder", metavar="SHARE", min=0, max=1, rich_help_panel=BAD_LINK, help="Of frames held back."),
]
NakOption: TypeAlias = Annotated[
    int | None,
    typer.Option(
        "--nak-at",
        metavar="N",
        min=0,
        rich_help_panel=BAD_LINK,
        help="Refuse item N as it is sent: from 0, which on ArduPilot is home.",
    ),
]
ReportOption: TypeAlias = Annotated[
    bool, typer.Option("--report", metavar="", help="Also write NAME.html: map, heights, speeds, times.")
]
JsonOption: TypeAlias = Annotated[
    bool, typer.Option("--json", metavar="", help="Print the result as JSON, for machines.")
]


def read_wind_option(given: str | None, profile: str | None = None) -> "Wind | None":
    """The wind as it was given: a speed [m/s], an @, and the direction that it comes from [deg]; None: none was.

    Its `profile` is an exponent, an @, and the gradient height [m].

    Raises:
        BadInput: what is not such a pair of numbers.
    """
    from ipoa_mission.wind import Wind

    if given is None:
        if profile is not None:
            raise BadInput(f"--wind-profile {profile}: expected a --wind that it belongs to")
        return None
    speed, at, direction = given.partition("@")
    try:
        wind = Wind(float(speed), float(direction))
    except ValueError:
        wind = Wind(math.nan)
    if not (at and 0 <= wind.speed < math.inf and abs(wind.from_deg) <= 360):
        raise BadInput(
            f"--wind {given}: expected a speed in m/s and where it blows from, in degrees up to 360, like 6@270"
        )
    if profile is None:
        return wind
    exponent, at, height = profile.partition("@")
    try:
        wind = replace(wind, exponent=float(exponent), gradient_height=float(height))
    except ValueError:
        wind = replace(wind, exponent=math.nan)
    if not (at and 0 <= wind.exponent < math.inf and 0 < wind.gradient_height < math.inf):
        raise BadInput(f"--wind-profile {profile}: expected an exponent and the gradient height in m, like 0.14@60")
    return wind


def read_parameter_options(given: list[str] | None, file: Path | None) -> dict[str, float]:
    """Parameters from a file, then those named on the command line, which win.

    Raises:
        BadInput: what is not NAME=VALUE with a known name and a number, or a file that cannot be read.
    """
    parameters: dict[str, float] = {}
    if file is not None:
        from ipoa_mission.mission.parameter_file import read_parameters

        parameters.update(read_parameters(file))
    for text in given or ():
        name, equals, value = text.partition("=")
        try:
            if not (name.strip() and equals and abs(number := float(value)) <= SINGLE_MAX):
                raise ValueError
        except ValueError:
            raise BadInput(f"--param {text}: expected NAME=VALUE with a number, like WPNAV_ACCEL=250") from None
        parameters[_known(name.strip().upper())] = number
    return parameters


def _known(name: str) -> str:
    """The same name, if either firmware's models know it: what else a vehicle has may come from a file."""
    from ipoa_mission.autopilots.parameters import expect_known

    try:
        expect_known([name])
    except BadInput as error:
        raise BadInput(f"--param {error}", hint=error.hint or "--param-file takes any parameter") from None
    return name
