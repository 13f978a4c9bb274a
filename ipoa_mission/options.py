import math
import os
from contextlib import suppress
from enum import StrEnum
from functools import partial
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import typer

from ipoa_mission.autopilot.autopilot import Autopilot, autopilot_named, autopilot_names
from ipoa_mission.autopilot.parameters import SINGLE_MAX
from ipoa_mission.errors import BadInput, Unreadable, Unwritable, WrongSuffix
from ipoa_mission.files import MISSIONS, near_name, packed

if TYPE_CHECKING:
    from ipoa_mission.link.signing import Signer
    from ipoa_mission.wind import Wind

NAMES = ("campus",)
ANYWAY = "Continue although a check fails: mission, home, firmware, class of vehicle, another vehicle with its id."
PASSPHRASE = "IPOA_MISSION_PASSPHRASE"


def flag(name: str, words: str, metavar: str | None = None, **settings: Any) -> Any:
    return typer.Option(name, help=words, metavar=metavar, **settings)


def argument(metavar: str, words: str, **settings: Any) -> Any:
    return typer.Argument(metavar=metavar, help=words, **settings)


link_option = partial(flag, rich_help_panel="The link")


class Backend(StrEnum):
    BUILTIN = "builtin"
    MAVSDK = "mavsdk"


def or_packed(path: Path) -> Path:
    """Return the named file, else the packed scenario of that name."""
    with suppress(OSError):  # too long a name
        if path.exists() or path.suffix.lower() in MISSIONS:
            return path
    if str(path) in NAMES:
        return packed(f"{path}.toml")
    hint = near_name(path.with_suffix(".toml")) or "ipoa-mission new NAME.toml writes a scenario"
    words = f"expected a scenario file (.toml), or `{'` or `'.join(NAMES)}`, but there is no such file"
    raise Unreadable(words, hint=hint, place=path)


def expect_scenario(path: Path) -> Path:
    if path.suffix.lower() in MISSIONS:
        words = "expected a scenario (.toml), not a mission"
        raise WrongSuffix(words, hint=f"fly takes missions: ipoa-mission fly {quote(str(path))}", place=path)
    return or_packed(path)


def expect_mission(path: Path) -> Path:
    if path.suffix.lower() == ".toml":
        words = "expected a mission (.plan, .waypoints), not a scenario"
        raise WrongSuffix(words, hint=f"first: ipoa-mission plan {quote(str(path))}", place=path)
    return path


FileArgument: TypeAlias = Annotated[
    Path, argument("FILE", "Mission file: .plan or .waypoints.", callback=expect_mission)
]
ScenarioOption: TypeAlias = Annotated[
    Path | None,
    flag(
        "--scenario",
        "Scenario of the flight: terrain, obstacles, wind, and the vehicle's parameters.",
        "SCENARIO",
        callback=lambda path: None if path is None else or_packed(path),
    ),
]
IgnoreOption: TypeAlias = Annotated[
    list[str] | None, flag("--ignore", "Ignore findings of this code, except those of a crash. Repeatable.", "CODE")
]
HomeOption: TypeAlias = Annotated[
    tuple[float, float, float] | None, flag("--home", "Home: degrees, and meters AMSL.", "LAT LON ALT")
]
ForceOption: TypeAlias = Annotated[bool, flag("--force", "Overwrite existing files, also those not written by a plan.")]
OutOption: TypeAlias = Annotated[Path, flag("--out", "Folder for the files, created if absent.", "DIR")]
SeedOption: TypeAlias = Annotated[int, flag("--seed", "Same seed, same bytes.", "N", min=0)]


def autopilot_called(name: str) -> Autopilot:
    try:
        return autopilot_named(name)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from None


autopilot_option = partial(typer.Option, "--autopilot", parser=autopilot_called, metavar="|".join(autopilot_names()))
AutopilotOption: TypeAlias = Annotated[
    Autopilot | None, autopilot_option(help="Firmware; default: the file's (.waypoints: by its items).")
]
FirmwareVersionOption: TypeAlias = Annotated[
    str | None, flag("--firmware-version", "Firmware version; default: newest measured, or vehicle's.", "X.Y")
]
UnmeasuredVersionOption: TypeAlias = Annotated[
    bool, flag("--unmeasured-version", "Accept a firmware version that was not measured in flights.")
]
ParameterOption: TypeAlias = Annotated[
    list[str] | None, flag("--param", "An autopilot's parameter that is not its default. Repeatable.", "NAME=VALUE")
]
ParameterFileOption: TypeAlias = Annotated[
    Path | None, flag("--param-file", "A file of such parameters: .parm or .params.", "FILE")
]
LinkOption: TypeAlias = Annotated[
    str, link_option("--link", "udpin:HOST:PORT, udpout:HOST:PORT, tcp:HOST:PORT, serial:DEVICE:BAUD.", "URL")
]
SystemOption: TypeAlias = Annotated[
    int | None, link_option("--system", "System id of the vehicle among several.", "N", min=1, max=255)
]
LogSystemOption: TypeAlias = Annotated[
    int | None, flag("--system", "System id of the vehicle in a .tlog.", "N", min=1, max=255)
]
KeyOption: TypeAlias = Annotated[
    Path | None,
    link_option(
        "--key",
        "Sign MAVLink with the key in this file; or set IPOA_MISSION_PASSPHRASE.",
        "FILE",
        envvar="IPOA_MISSION_KEY",
    ),
]
ReportOption: TypeAlias = Annotated[bool, flag("--report", "Also write NAME.html: map, heights, speeds, times.")]
JsonOption: TypeAlias = Annotated[bool, flag("--json", "Print the result as JSON, for machines.")]


def read_wind_option(text: str | None) -> "Wind | None":
    """Return a wind `SPEED@FROM` [m/s], [deg]."""
    from ipoa_mission.wind import Wind

    if text is None:
        return None
    speed_text, _, from_text = text.partition("@")
    speed = read_number(speed_text)
    from_deg = read_number(from_text)
    if not (0 <= speed < math.inf and abs(from_deg) <= 360):
        words = "expected a speed [m/s] and the direction it comes from [deg, to 360], like 6@270"
        raise BadInput(words, place=f"--wind {text}")
    return Wind(speed, from_deg)


def read_number(text: str) -> float:
    """Return NaN for what a parameter file does not take as a number, such as 1_0."""
    from ipoa_mission.mission.parameter_file import NUMBER

    return float(text) if NUMBER.fullmatch(text.strip()) else math.nan


def read_parameter_options(texts: list[str] | None, file: Path | None) -> tuple[dict[str, float], tuple[str, ...]]:
    """Return the file's parameters, overridden by the command line's, and remarks."""
    parameters = dict[str, float]()
    remarks = tuple[str, ...]()
    if file is not None:
        from ipoa_mission.mission.parameter_file import read_parameter_file

        read = read_parameter_file(file)
        parameters.update(read.parameters)
        remarks = tuple(thing.words for thing in read.unread)
    for text in texts or ():
        name, _, value = text.partition("=")
        number = read_number(value)
        if not (name.strip() and abs(number) <= SINGLE_MAX):
            raise BadInput("expected NAME=VALUE with a number, like WPNAV_ACCEL=250", place=f"--param {text}")
        parameters[_known(name.strip().upper())] = number
    return parameters, remarks


def _known(name: str) -> str:
    """Return a name that the firmware's model uses; others may come from a file."""
    from ipoa_mission.autopilot.known_parameters import expect_known

    try:
        expect_known([name])
    except BadInput as error:
        error.place = f"--param {error.place}"
        raise error.at(hint=error.hint or "--param-file takes any parameter") from None
    return name


def signer_of(key: Path | None, role: str = "station") -> "Signer | None":
    """Return a signer by the key file, else the environment; each role has own timestamps."""
    words = os.environ.get(PASSPHRASE)
    if key is None and not words:
        return None
    from ipoa_mission.link.signing import key_of, persistent_signer, read_key

    secret = read_key(key) if key is not None else key_of(words or "")
    folder = state_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    except OSError as error:
        message = f"cannot be created: {error.strerror}"
        raise Unwritable(message, hint="it holds the timestamps of signatures", place=folder) from error
    return persistent_signer(secret, folder / f"signing-{role}.timestamp")


def state_folder() -> Path:
    """Return `ipoa-mission` in `$XDG_STATE_HOME`, else in `%LOCALAPPDATA%` or `~/.local/state`."""
    base = os.environ.get("XDG_STATE_HOME") or os.environ.get("LOCALAPPDATA") or Path.home() / ".local" / "state"
    return Path(base) / "ipoa-mission"
