"""Whether a mission may go on this very vehicle: what the command line and the studio ask before they upload."""

import logging
from dataclasses import replace

from ipoa_mission.checks.check import check_mission
from ipoa_mission.checks.unsafe import refuse_errors
from ipoa_mission.errors import MissionError
from ipoa_mission.flight.homes import compare_homes
from ipoa_mission.items import Mission
from ipoa_mission.link.dialogue import NoAnswer
from ipoa_mission.link.vehicle import Vehicle

log = logging.getLogger(__name__)


def expect_fit(mission: Mission, vehicle: Vehicle, anyway: bool = False) -> tuple[str, ...]:
    """Check a mission as this vehicle would meet it; what comes back are remarks for the user. Nothing is sent.

    Raises:
        Unsafe, FarFromHome: it would crash or be refused, and `anyway` does not say to send it all the same.
        MissionError: it was made for another autopilot.
    """
    if mission.autopilot is not vehicle.autopilot and not anyway:
        raise MissionError(
            f"the mission was made for {mission.autopilot}, and the vehicle is {vehicle.autopilot}: "
            "its path and its time would be others",
            hint=f"make it for {vehicle.autopilot} (--autopilot {vehicle.autopilot}), or send it with --anyway",
        )
    findings = check_mission(replace(mission, autopilot=vehicle.autopilot))
    warnings = findings if anyway else refuse_errors(findings)
    return (*_compare_home(mission, vehicle, anyway), *(finding.message for finding in warnings))


def _compare_home(mission: Mission, vehicle: Vehicle, anyway: bool) -> tuple[str, ...]:
    try:
        there = vehicle.home()
    except NoAnswer:
        there = None
    if there is None:
        return ("the vehicle does not say where its home is: nobody compared it with the mission's",)
    log.info("the vehicle's home: %.6f, %.6f, %.1f m AMSL", there.latitude_deg, there.longitude_deg, there.altitude)
    return compare_homes(mission, there, anyway)
