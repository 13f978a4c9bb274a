from collections.abc import Mapping
from contextlib import closing, suppress
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import TYPE_CHECKING, Annotated

import ipoa_mission.options as options
from ipoa_mission.autopilot.autopilot import Autopilot, default_autopilot
from ipoa_mission.errors import BadInput, OptionConflict
from ipoa_mission.terminal import notes, print_json, print_lines

if TYPE_CHECKING:
    from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot

faulty = partial(options.flag, rich_help_panel="Faults of the link")
ZURICH = (47.397742, 8.545594, 488.0)


@dataclass
class FaultOptions:
    loss: Annotated[float, faulty("--loss", "Share of lost frames.", "SHARE", min=0, max=1)] = 0.0
    duplicate: Annotated[float, faulty("--duplicate", "Share of duplicated frames.", "SHARE", min=0, max=1)] = 0.0
    delay: Annotated[float, faulty("--delay", "Delay of a frame [s].", "S", min=0)] = 0.0
    reorder: Annotated[float, faulty("--reorder", "Share of reordered frames.", "SHARE", min=0, max=1)] = 0.0


@dataclass
class MockOptions:
    autopilot: Annotated[
        Autopilot | None, options.autopilot_option(help="Autopilot to simulate; default: the scenario's, or px4.")
    ] = None
    scenario: options.ScenarioOption = None
    home: options.HomeOption = None
    firmware_version: Annotated[
        str | None, options.flag("--firmware-version", "Firmware version; default: the newest measured one.", "X.Y")
    ] = None
    param: options.ParameterOption = None
    param_file: options.ParameterFileOption = None
    link: Annotated[
        str, options.link_option("--link", "udpin, udpout, tcpin; loopback unless a host is named.", "URL")
    ] = "udpin:127.0.0.1:14540"
    speedup: Annotated[float, options.flag("--speedup", "Speed-up: times real time.", "N", min=0.01, max=1000)] = 1.0
    system: options.SystemOption = None
    key: options.KeyOption = None
    seed: Annotated[int, faulty("--seed", "Seed of the losses.", "N", min=0)] = 0


def mock(worse: FaultOptions, how: MockOptions, as_json: options.JsonOption = False) -> None:
    """Simulate an autopilot: answer and fly as PX4 or ArduPilot until Ctrl-C, for any ground station.

    While a list is transferred or it waits armed, it runs at real speed. It sends at most 2000 messages a second, the
    limit of a busy ground station.

    With `--json` one line gives its address before the first answer.

    Example: `ipoa-mission mock --scenario campus --link tcpin:127.0.0.1:5760 --speedup 10`
    """
    from ipoa_mission.link.channel import open_channel, parse_address
    from ipoa_mission.simulator.station import Faults, Server, Station

    address = parse_address(how.link)
    system = how.system or 1
    parameters, remarks = options.read_parameter_options(how.param, how.param_file)
    autopilot = built_in_autopilot(how, parameters)
    name = str(autopilot.profile.autopilot)
    version = autopilot.profile.version
    home = autopilot.flight.home
    signer = options.signer_of(how.key, "mock")
    faults = Faults(worse.loss, worse.duplicate, worse.delay, worse.reorder)

    @cache
    def print_address() -> bool:
        """Print once, when the server asks first whether it is to end."""
        if as_json:
            place = {"latitude_deg": home.latitude_deg, "longitude_deg": home.longitude_deg}
            place["altitude_amsl"] = home.altitude
            simulated = {"autopilot": name, "version": str(version), "link": str(address), "system": system}
            print_json(simulated | {"home": place, "speedup": how.speedup, "remarks": list(remarks)}, indent=None)
        else:
            words = f"{name} {version} at {address}, {how.speedup:g} times as fast as real; Ctrl-C ends it"
            print_lines(words, *notes(remarks))
        return False

    with suppress(KeyboardInterrupt), closing(open_channel(how.link)) as channel:
        station = Station(autopilot, system, signer)
        Server(channel, station, how.speedup, faults, how.seed).run(print_address)


def built_in_autopilot(how: MockOptions, parameters: Mapping[str, float]) -> "BuiltInAutopilot":
    from ipoa_mission.autopilot.known_parameters import expect_own
    from ipoa_mission.autopilot.version import Version
    from ipoa_mission.geodesy import Geodetic
    from ipoa_mission.scenario import read_scenario
    from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot
    from ipoa_mission.simulator.situation import Conditions

    home = how.home or ZURICH
    family = how.autopilot or default_autopilot()
    conditions = Conditions(cold=True)
    if not (-90 <= home[0] <= 90 and -180 <= home[1] <= 180):
        raise BadInput(f"expected latitude and longitude in degrees, not {home[0]} {home[1]}", place="--home")
    place = Geodetic(*home)
    if how.scenario is not None:
        if how.home is not None:
            raise OptionConflict("cannot be combined with --scenario, which defines home", place="--home")
        world = read_scenario(how.scenario)
        family = how.autopilot or world.vehicle.autopilot
        place = world.home.geodetic()
        conditions = replace(conditions, wind=world.wind.air(), ground=world.ground)
        if family is world.vehicle.autopilot:
            parameters = family.parameter_table.overridden(world.vehicle.parameters, parameters)
            conditions = replace(conditions, vehicle=world.vehicle.learned, version=world.vehicle.version)
    expect_own(parameters, family)
    if how.firmware_version is not None:
        conditions = replace(conditions, version=family.tables.expect(Version.parsed(how.firmware_version)))
    return BuiltInAutopilot(family, place, parameters, conditions=conditions)
