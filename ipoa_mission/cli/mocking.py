from collections.abc import Mapping
from contextlib import closing, suppress
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ipoa_mission.autopilot.autopilot import Autopilot, default_autopilot
from ipoa_mission.cli.groups import FaultOptions
from ipoa_mission.errors import BadInput, OptionConflict
from ipoa_mission.options import (
    HomeOption,
    JsonOption,
    KeyOption,
    ParameterFileOption,
    ParameterOption,
    ScenarioOption,
    SystemOption,
    autopilot_option,
    bad_link_option,
    link_option,
    read_parameter_options,
    signer_of,
)
from ipoa_mission.terminal import notes, print_json, print_lines

if TYPE_CHECKING:
    from ipoa_mission.geodesy import Geodetic
    from ipoa_mission.simulator.situation import Conditions

ZURICH = (47.397742, 8.545594, 488.0)


@dataclass
class MockOptions:
    autopilot: Annotated[
        Autopilot | None, autopilot_option(help="Autopilot to simulate; default: the scenario's, or px4.")
    ] = None
    scenario: ScenarioOption = None
    home: HomeOption = None
    firmware_version: Annotated[
        str | None,
        typer.Option("--firmware-version", metavar="X.Y", help="Firmware version; default: the newest measured one."),
    ] = None
    param: ParameterOption = None
    param_file: ParameterFileOption = None
    link: Annotated[
        str, link_option("--link", metavar="URL", help="udpin or udpout, tcpin; loopback unless you name another host.")
    ] = "udpin:127.0.0.1:14540"
    speedup: Annotated[
        float, typer.Option("--speedup", metavar="N", min=0.01, max=1000, help="Speed-up: times real time.")
    ] = 1.0
    system: SystemOption = None
    key: KeyOption = None
    seed: Annotated[int, bad_link_option("--seed", metavar="N", min=0, help="Seed of the losses.")] = 0


def mock(worse: FaultOptions, options: MockOptions, as_json: JsonOption = False) -> None:
    """Simulate an autopilot: answer and fly as PX4 or ArduPilot until Ctrl-C, for any ground station.

    While a list is transferred or it waits armed, it runs at real speed. It sends at most 2000 messages a second, the
    limit of a busy ground station.

    With `--json` one line gives its address before the first answer.

    Example: `ipoa-mission mock --scenario campus --link tcpin:127.0.0.1:5760 --speedup 10`
    """
    from ipoa_mission.autopilot.known_parameters import expect_own
    from ipoa_mission.autopilot.version import Version
    from ipoa_mission.link.channel import open_channel, parse_address
    from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot as Mock
    from ipoa_mission.simulator.mock_server import Server
    from ipoa_mission.simulator.station import Station

    address, system, speedup = parse_address(options.link), options.system or 1, options.speedup
    parameters, remarks = read_parameter_options(options.param, options.param_file)
    setup = mock_setup(options.scenario, options.home, options.autopilot, parameters)
    expect_own(setup.parameters, setup.autopilot)
    if options.firmware_version is not None:
        named = setup.autopilot.tables.expect(Version.parsed(options.firmware_version))
        setup = replace(setup, conditions=replace(setup.conditions, version=named))
    version, home = setup.conditions.version or setup.autopilot.newest, setup.home
    degrees = {"latitude_deg": home.latitude_deg, "longitude_deg": home.longitude_deg}
    signer = signer_of(options.key, "mock")

    @cache
    def print_address() -> bool:
        """Print once, when the server asks first whether it is to end."""
        if as_json:
            about = {
                "autopilot": str(setup.autopilot),
                "version": str(version),
                "link": str(address),
                "system": system,
                "home": degrees | {"altitude_amsl": home.altitude},
                "speedup": speedup,
                "remarks": list(remarks),
            }
            print_json(about, indent=None)
        else:
            words = f"{setup.autopilot} {version} at {address}, {speedup:g} times as fast as real; Ctrl-C ends it"
            print_lines(words, *notes(remarks))
        return False

    conditions = replace(setup.conditions, cold=True)
    autopilot = Mock(setup.autopilot, home, setup.parameters, conditions=conditions)
    with suppress(KeyboardInterrupt), closing(open_channel(options.link)) as channel:
        station = Station(autopilot, system, signer, channel.datagrams)
        Server(channel, station, speedup, worse.faults(), options.seed).run(print_address)


@dataclass(frozen=True)
class MockSetup:
    autopilot: Autopilot
    home: "Geodetic"
    parameters: Mapping[str, float]
    conditions: "Conditions"


def mock_setup(
    scenario: Path | None,
    home: tuple[float, float, float] | None,
    autopilot: Autopilot | None,
    parameters: Mapping[str, float],
) -> MockSetup:
    """Return the scenario's values, replaced by options."""
    from ipoa_mission.geodesy import Geodetic
    from ipoa_mission.scenario import read_scenario
    from ipoa_mission.simulator.situation import STANDARD_CONDITIONS, Conditions

    if home is not None and not (-90 <= home[0] <= 90 and -180 <= home[1] <= 180):
        raise BadInput(f"expected latitude and longitude in degrees, not {home[0]} {home[1]}", place="--home")
    if scenario is None:
        return MockSetup(autopilot or default_autopilot(), Geodetic(*(home or ZURICH)), parameters, STANDARD_CONDITIONS)
    if home is not None:
        raise OptionConflict("cannot be combined with --scenario, which defines home", place="--home")
    world = read_scenario(scenario)
    flies = autopilot or world.vehicle.autopilot
    vehicle = world.vehicle if flies is world.vehicle.autopilot else None
    values = flies.parameter_table.overridden(world.vehicle.parameters, parameters) if vehicle else parameters
    about = (vehicle.learned, vehicle.version) if vehicle else ()
    conditions = Conditions(world.wind.air(), world.ground, *about)
    return MockSetup(flies, world.home.geodetic(), values, conditions)
