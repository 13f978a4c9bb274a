"""Options that several verbs share, each said once."""

import math
from enum import StrEnum
from functools import partial
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from ipoa_mission.errors import BadInput, OptionConflict, WrongSuffix
from ipoa_mission.files import MISSIONS, packed
from ipoa_mission.vehicles.autopilot import Autopilot, autopilot_named, registered
from ipoa_mission.vehicles.parameters import SINGLE_MAX

if TYPE_CHECKING:
    from ipoa_mission.wind import Wind

#: Scenarios that are packed with the program, to be planned by their name.
NAMES = ("campus",)
ANYWAY = "Do it although a check fails: mission, home, firmware, class of vehicle, another vehicle with its id."
#: Options that `--help` gathers under a heading.
link_option = partial(typer.Option, rich_help_panel="The link")
bad_link_option = partial(typer.Option, rich_help_panel="A worse link to the built-in autopilot, to see what happens")


class Backend(StrEnum):
    """Who speaks MAVLink for us."""

    BUILTIN = "builtin"
    MAVSDK = "mavsdk"


def optimizers_like(beginning: str) -> list[str]:
    """The optimizers whose names begin so, for a shell that completes."""
    from ipoa_mission.optimize.registry import optimizer_names

    return [name for name in optimizer_names() if name.startswith(beginning)]


def or_packed(path: Path) -> Path:
    """The file that was named; where there is none and the name is one of `NAMES`, the scenario of that name."""
    return packed(f"{path}.toml") if str(path) in NAMES and not path.exists() else path


def expect_scenario(path: Path) -> Path:
    """The scenario's file, or one that is packed; BadInput for a mission file."""
    if path.suffix.lower() in MISSIONS:
        words = "expected a scenario (.toml), not a mission"
        raise WrongSuffix(words, hint=f"fly takes missions: ipoa-mission fly {quote(str(path))}", place=path)
    return or_packed(path)


def expect_mission(path: Path) -> Path:
    """Raise BadInput for a scenario where a mission file is expected."""
    if path.suffix.lower() == ".toml":
        words = "expected a mission (.plan, .waypoints), not a scenario"
        raise WrongSuffix(words, hint=f"first: ipoa-mission plan {quote(str(path))}", place=path)
    return path


def expect_world_of(endings: bool, scenario: Path | None) -> None:
    """Raise BadInput where endings are asked for without a scenario."""
    if endings and scenario is None:
        words = "expected with --scenario"
        raise OptionConflict(words, hint="what an ending keeps depends on what stands there", place="--endings")


ScenarioOrNone: TypeAlias = Annotated[
    Path | None,
    typer.Argument(
        metavar="[SCENARIO]",
        callback=lambda path: None if path is None else expect_scenario(path),
        help="Scenario file (TOML), or `campus`; with --survey it may be left out.",
    ),
]
FileArgument: TypeAlias = Annotated[
    Path, typer.Argument(metavar="FILE", callback=expect_mission, help="Mission file: .plan or .waypoints.")
]
ScenarioOption: TypeAlias = Annotated[
    Path | None,
    typer.Option(
        "--scenario",
        metavar="SCENARIO",
        callback=lambda path: None if path is None else or_packed(path),
        help="The world it flies in: terrain, obstacles, wind, and the vehicle's parameters.",
    ),
]
IgnoreOption: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        "--ignore", metavar="CODE", help="Leave out the findings of a code; not those of a crash. Repeatable."
    ),
]
EndingsOption: TypeAlias = Annotated[
    bool, typer.Option("--endings", help="What RTL, LAND and the like would do from every second of the flight.")
]
ForceOption: TypeAlias = Annotated[
    bool, typer.Option("--force", metavar="", help="Write over files that are there, also those not written by a plan.")
]
OutOption: TypeAlias = Annotated[
    Path, typer.Option("--out", metavar="DIR", help="Folder for the files; made if absent.")
]
SeedOption: TypeAlias = Annotated[int, typer.Option("--seed", metavar="N", min=0, help="Same seed, same bytes.")]


def autopilot_called(name: str) -> Autopilot:
    """The autopilot of a name on the command line."""
    try:
        return autopilot_named(name)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from None


#: How an option that names an autopilot is read.
autopilot_option = partial(
    typer.Option, "--autopilot", parser=autopilot_called, metavar="|".join(one.name for one in registered())
)
AutopilotOption: TypeAlias = Annotated[
    Autopilot | None,
    autopilot_option(help="Firmware that flies it; left out, what the file says (.waypoints: by its items)."),
]
FirmwareVersionOption: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--firmware-version",
        metavar="X.Y",
        help="Version of the firmware, like 1.17; left out, the newest that was measured, on a link the vehicle's own.",
    ),
]
UnmeasuredVersionOption: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--unmeasured-version", metavar="", help="Go on although flights of the firmware's version were not measured."
    ),
]
ParameterOption: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        "--param", metavar="NAME=VALUE", help="A parameter that the autopilot has, not its default. Repeatable."
    ),
]
ParameterFileOption: TypeAlias = Annotated[
    Path | None, typer.Option("--param-file", metavar="FILE", help="A file of such parameters: .parm or .params.")
]
LinkOption: TypeAlias = Annotated[
    str,
    link_option("--link", metavar="URL", help="udpin:HOST:PORT, udpout:HOST:PORT, tcp:HOST:PORT, serial:DEVICE:BAUD."),
]
SystemOption: TypeAlias = Annotated[
    int | None,
    link_option("--system", metavar="N", min=1, max=255, help="The vehicle's system id, if there are several."),
]
LogSystemOption: TypeAlias = Annotated[
    int | None,
    typer.Option("--system", metavar="N", min=1, max=255, help="The vehicle's system id, in a .tlog of several."),
]
KeyOption: TypeAlias = Annotated[
    Path | None,
    link_option(
        "--key",
        metavar="FILE",
        envvar="IPOA_MISSION_KEY",
        help="Sign MAVLink with the key in this file; or set IPOA_MISSION_PASSPHRASE.",
    ),
]
ReportOption: TypeAlias = Annotated[
    bool, typer.Option("--report", metavar="", help="Also write NAME.html: map, heights, speeds, times.")
]
JsonOption: TypeAlias = Annotated[
    bool, typer.Option("--json", metavar="", help="Print the result as JSON, for machines.")
]


def read_wind_option(given: str | None) -> "Wind | None":
    """The wind as it was given: a speed [m/s], an @, and the direction that it comes from [deg]; None: none was.

    Raises:
        BadInput: what is not such a pair of numbers.
    """
    from ipoa_mission.wind import Wind

    if given is None:
        return None
    one, _, other = given.partition("@")
    try:
        speed, from_deg = float(one), float(other)
        if not (0 <= speed < math.inf and abs(from_deg) <= 360):
            raise ValueError
    except ValueError:
        words = "expected a speed in m/s and where it blows from, in degrees up to 360, like 6@270"
        raise BadInput(words, place=f"--wind {given}") from None
    return Wind(speed, from_deg)


def read_parameter_options(given: list[str] | None, file: Path | None) -> dict[str, float]:
    """Parameters from a file, then those named on the command line, which win.

    Raises:
        BadInput: what is not NAME=VALUE with a known name and a number, or a file that cannot be read.
    """
    parameters: dict[str, float] = {}
    if file is not None:
        from ipoa_mission.cli.output import notes, shown
        from ipoa_mission.mission.parameter_file import read_parameter_file

        read = read_parameter_file(file)
        parameters.update(read.parameters)
        for note in notes(thing.words for thing in read.unread):
            typer.echo(shown(note), err=True)
    for text in given or ():
        name, equals, value = text.partition("=")
        try:
            if not (name.strip() and equals and abs(number := float(value)) <= SINGLE_MAX):
                raise ValueError
        except ValueError:
            raise BadInput("expected NAME=VALUE with a number, like WPNAV_ACCEL=250", place=f"--param {text}") from None
        parameters[_known(name.strip().upper())] = number
    return parameters


def _known(name: str) -> str:
    """The same name, if either firmware's models know it: what else a vehicle has may come from a file."""
    from ipoa_mission.vehicles.known_parameters import expect_known

    try:
        expect_known([name])
    except BadInput as error:
        error.place, error.hint = f"--param {error.place}", error.hint or "--param-file takes any parameter"
        raise error from None
    return name
