"""`mock`: the built-in autopilot behind a port, for any ground station."""

from typing import Annotated

import typer

from ipoa_mission.autopilots.vehicle import Autopilot
from ipoa_mission.cli.groups import FaultOptions
from ipoa_mission.cli.options import (
    JsonOption,
    KeyOption,
    ParameterFileOption,
    ParameterOption,
    SystemOption,
    bad_link_option,
    link_option,
    read_parameter_options,
)
from ipoa_mission.cli.telling import tell, tell_json
from ipoa_mission.errors import BadInput

ZURICH = (47.397742, 8.545594, 488.0)


def mock(
    worse: FaultOptions,
    autopilot: Annotated[Autopilot, typer.Option("--autopilot", help="Whom to answer as.")] = Autopilot.PX4,
    link: Annotated[
        str, link_option("--link", metavar="URL", help="udpin or udpout, tcpin; loopback unless you name another host.")
    ] = "udpin:127.0.0.1:14540",
    home: Annotated[
        tuple[float, float, float],
        typer.Option("--home", metavar="LAT LON ALT", help="Where it stands: degrees, and metres AMSL."),
    ] = ZURICH,
    speedup: Annotated[
        float, typer.Option("--speedup", metavar="N", min=0.01, max=1000, help="So many times as fast as real.")
    ] = 1.0,
    firmware_version: Annotated[
        str | None, typer.Option("--firmware-version", metavar="X.Y", help="Of which version; left out, the measured.")
    ] = None,
    param: ParameterOption = None,
    param_file: ParameterFileOption = None,
    system: SystemOption = None,
    key: KeyOption = None,
    seed: Annotated[int, bad_link_option("--seed", metavar="N", min=0, help="Same seed, same losses.")] = 0,
    as_json: JsonOption = False,
) -> None:
    """Be an autopilot: answer and fly as PX4 or as ArduPilot until Ctrl-C, for any ground station.

    With `--json` one line says who is where, before anybody is answered.

    Example: `ipoa-mission mock --autopilot ardupilot --link tcpin:127.0.0.1:5760 --speedup 10`
    """
    from ipoa_mission.autopilots.firmware import expect_known_version
    from ipoa_mission.autopilots.parameters import expect_own
    from ipoa_mission.autopilots.version import MEASURED, Version
    from ipoa_mission.cli.signing import signer_of
    from ipoa_mission.link.address import parse_address
    from ipoa_mission.simulator.autopilot import Autopilot as Mock
    from ipoa_mission.simulator.server import serve
    from ipoa_mission.world.frame import Geodetic

    latitude_deg, longitude_deg, altitude = home
    if not (-90 <= latitude_deg <= 90 and -180 <= longitude_deg <= 180):
        raise BadInput(f"--home: expected latitude and longitude in degrees, not {latitude_deg} {longitude_deg}")
    address = parse_address(link)
    parameters = read_parameter_options(param, param_file)
    expect_own(parameters, autopilot)
    version = MEASURED[autopilot]
    if firmware_version is not None:
        version = expect_known_version(autopilot, Version.parsed(firmware_version))
    signer = signer_of(key, "mock")
    place = {"latitude_deg": latitude_deg, "longitude_deg": longitude_deg, "altitude_amsl": altitude}
    about = {
        "autopilot": str(autopilot),
        "version": str(version),
        "link": str(address),
        "system": system or 1,
        "home": place,
        "speedup": speedup,
    }
    is_told = False

    def tell_once() -> bool:
        nonlocal is_told
        if not is_told and as_json:
            tell_json(about, indent=None)
        elif not is_told:
            tell(f"{autopilot} {version} at {address}, {speedup:g} times as fast as real; Ctrl-C ends it")
        is_told = True
        return False

    try:
        serve(
            link,
            Mock(autopilot, Geodetic(*home), parameters, cold=True, nak_at=worse.nak_at, version=version),
            speedup,
            worse.faults(),
            system or 1,
            seed,
            signer,
            until=tell_once,  # first asked when the link is open
        )
    except KeyboardInterrupt:
        return
