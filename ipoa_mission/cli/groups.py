import re
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path
from typing import Annotated

import ipoa_mission.options as options
from ipoa_mission.errors import BadInput
from ipoa_mission.mission.flight_record import OnDeviation
from ipoa_mission.terminal import expect_free


@dataclass
class SearchOptions:
    seed: options.SeedOption = 0
    optimizer: Annotated[
        str | None, options.flag("--optimizer", "Search algorithm, like ipoa or poa, also an installed one.", "NAME")
    ] = None


@dataclass
class FlownByOptions:
    autopilot: options.AutopilotOption = None
    firmware_version: options.FirmwareVersionOption = None
    unmeasured_version: options.UnmeasuredVersionOption = False
    param: options.ParameterOption = None
    param_file: options.ParameterFileOption = None
    wind: Annotated[
        str | None, options.flag("--wind", "A steady wind by speed and origin: 6@270 is from the west.", "M/S@DEG")
    ] = None
    vehicle: Annotated[
        Path | None, options.flag("--vehicle", "A vehicle file written by `learn`: drag, lag, delays, power.", "FILE")
    ] = None

    def __post_init__(self) -> None:
        from ipoa_mission.autopilot.version import Version

        self.parameters, self.parameter_remarks = options.read_parameter_options(self.param, self.param_file)
        self.version = None if self.firmware_version is None else Version.parsed(self.firmware_version)
        self.air = options.read_wind_option(self.wind)


@dataclass
class WorldOptions:
    flown_by: FlownByOptions
    scenario: options.ScenarioOption = None
    ignore: options.IgnoreOption = None


@dataclass
class FileOutput:
    folder: options.OutOption = Path()
    report: options.ReportOption = False
    force: options.ForceOption = False
    as_json: options.JsonOption = False

    def expect_plans(self, names: Iterable[str]) -> None:
        """Refuse to overwrite anything but unchanged earlier plans."""
        from ipoa_mission.mission.mission_io import not_as_written

        paths = (path for name in names for path in not_as_written(self.folder, name, self.report))
        expect_free(paths, self.force, ask=not self.as_json)


@dataclass
class LinkOptions:
    system: options.SystemOption = None
    log: Annotated[
        Path | None, options.link_option("--log", "Log of every frame (.tlog); default: next to the mission.", "FILE")
    ] = None
    key: options.KeyOption = None
    timeout: Annotated[
        float | None,
        options.link_option(
            "--timeout",
            "Give up after this time [s], also in flight: the vehicle is no longer watched then. "
            "Default: one hour until a flight begins.",
            "S",
            min=1.0,
        ),
    ] = None
    backend: Annotated[options.Backend, options.link_option("--backend", "MAVLink implementation.")] = (
        options.Backend.BUILTIN
    )
    anyway: Annotated[bool, options.link_option("--anyway", options.ANYWAY)] = False

    def written(self, usual_log: Path | None) -> list[str]:
        log = self.log or usual_log
        return [] if self.backend is options.Backend.MAVSDK or log is None else [str(log)]


@dataclass
class FlightOptions:
    link: Annotated[
        str | None, options.link_option("--link", "Vehicle, like udpin:HOST:PORT; default: the built-in one.", "URL")
    ] = None
    begin: Annotated[
        int, options.link_option("--from", "Begin at item N of `show`; the path there is checked.", "N", min=1)
    ] = 1
    set_params: Annotated[
        bool, options.link_option("--set-params", "Write parameters of the scenario and --param that differ aboard.")
    ] = False
    on_deviation: Annotated[
        OnDeviation, options.link_option("--on-deviation", "Order sent once if the flight deviates from the forecast.")
    ] = OnDeviation.HOLD
    depart_at: Annotated[
        str | None,
        options.link_option("--depart-at", "Arm at HH:MM:SS, local, or as 2026-11-30T14:05:30Z; not 3 s late.", "TIME"),
    ] = None

    def __post_init__(self) -> None:
        self.departure = read_departure_option(self.depart_at)

    def given_for_link(self) -> dict[str, bool]:
        deviates = self.on_deviation is not OnDeviation.HOLD
        given = {"--from": self.begin != 1, "--set-params": self.set_params, "--on-deviation": deviates}
        return given | {"--depart-at": self.departure is not None}


def read_departure_option(text: str | None) -> datetime | None:
    """Return a time of the next 24 hours, with its zone; raise BadInput."""
    if text is None:
        return None
    now = datetime.now().astimezone()
    try:
        full = f"{now.date()}T{text}" if re.fullmatch(r"\d\d:\d\d:\d\d", text) else text
        at = datetime.fromisoformat(full).astimezone()
    except (ValueError, OverflowError):  # of the year 1
        at = now
    if not timedelta(0) < at - now < timedelta(1):
        words = "expected a time within the next 24 hours, like 14:05:30 of today, or 2026-11-30T14:05:30Z"
        raise BadInput(words, place=f"--depart-at {text}")
    return at
