"""Whether a mission may go on this very vehicle: what the command line and the studio ask before they upload."""

import logging
import math
from dataclasses import replace

from ipoa_mission.checks.check import check_mission
from ipoa_mission.checks.ground_check import landings, touches_down
from ipoa_mission.checks.own_fence_check import breaches
from ipoa_mission.checks.positions import refusals
from ipoa_mission.checks.unsafe import Unsafe, refuse_errors
from ipoa_mission.checks.version_check import NOT_MEASURED, check_aboard
from ipoa_mission.errors import MissionError
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.link.dialogue import NoAnswer, TimeUp
from ipoa_mission.link.vehicle import Vehicle
from ipoa_mission.link.vehicle_setup import own_values
from ipoa_mission.link.vehicle_state import NotReady
from ipoa_mission.mission.commands import Frame, plain_frame
from ipoa_mission.mission.items import Mission
from ipoa_mission.progress import Progress, silent
from ipoa_mission.world.frame import Geodetic, apart

FAR = 100.0  # [m] over the ground
HIGHER = 5.0  # [m]
CHARGED = 0.95  # a charged battery is told as so full or fuller
log = logging.getLogger(__name__)


class FarFromHome(MissionError):
    """The vehicle is somewhere else; heights above home would be above another ground."""


def compare_homes(mission: Mission, there: Geodetic, anyway: bool = False) -> tuple[str, ...]:
    """Hold the vehicle's home against the mission's; what comes back are remarks for the user.

    Raises:
        FarFromHome: it is over 100 m away, heights count from home, and `anyway` does not say to send it all the same.
    """
    here = mission.home
    aside, higher = apart(here, there), there.altitude - here.altitude
    if aside > FAR:
        words = (
            f"the vehicle's home is {_distance(aside)} from the mission's: "
            f"it is at {_place(there)}, and the mission takes off at {_place(here)}"
        )
        if counts_from_home(mission) and not anyway:
            raise FarFromHome(
                words,
                hint="heights count from the vehicle's home: plan from where it stands, or send it with --anyway; "
                "one that was moved since it was armed last has its home where it stands once it is restarted "
                f"(the built-in autopilot goes there by `mock --home {_words(here)}`)",
            )
        return (words,)
    if math.isfinite(higher) and abs(higher) > HIGHER:
        return (
            f"the vehicle's home is {abs(higher):.1f} m {'higher' if higher > 0 else 'lower'} than the mission's "
            f"({there.altitude:.1f} m AMSL, not {here.altitude:.1f} m); heights count from the vehicle's",
        )
    return ()


def counts_from_home(mission: Mission) -> bool:
    """Whether some height in the mission is above home."""
    return any(item.has_position and plain_frame(item.frame) == Frame.GLOBAL_RELATIVE_ALT for item in mission.items)


def _distance(metres: float) -> str:
    return f"{metres:.0f} m" if metres < 10_000 else f"{metres / 1000:.0f} km"


def _place(place: Geodetic) -> str:
    return f"{place.latitude_deg:.5f}, {place.longitude_deg:.5f}"


def _words(place: Geodetic) -> str:
    return f"{place.latitude_deg:.6f} {place.longitude_deg:.6f} {place.altitude:.1f}"


class FastLanding(MissionError):
    """With the parameters that it has the vehicle would touch down fast, and with the mission's it would not."""


def expect_slow_landing(vehicle: Vehicle, forecast: Forecast) -> None:
    """Refuse a vehicle that would touch down fast because it has not the parameters that the mission was made for.

    Raises:
        FastLanding: naming the place, the ground there, and how fast.
    """
    mission = forecast.mission
    planned = mission.autopilot.slow_stretch(mission.parameters)
    if mission.autopilot is not vehicle.autopilot or planned is None or forecast.ground.is_level:
        return
    own = vehicle.autopilot.slow_stretch(own_values(vehicle, vehicle.autopilot.slowed_by.decided_by))
    for landing in landings(forecast):
        if own is not None and own.is_fast(landing.counted) and not planned.is_fast(landing.counted):
            raise FastLanding(
                f"{landing.words}: with the vehicle's own parameters, {touches_down(own, landing)}",
                hint="give it those that the mission was made for (NAME.params): `fly --set-params` does; "
                "--anyway flies with its own",
            )


class LowBattery(MissionError):
    """By the vehicle's own word its battery is not enough for the flight and its reserve."""


def expect_charge(vehicle: Vehicle, forecast: Forecast, first: int = 0) -> None:
    """Refuse a vehicle that would land with less than the scenario's reserve, by what it says of its battery.

    `first`: index of the item with which the flight begins.

    Raises:
        LowBattery: with how much is left, and with what it would land.
    """
    left = vehicle.state.battery_left
    if forecast.scenario is None or left is None or left >= CHARGED:
        return
    from ipoa_mission.forecast.energy_budget import budget_of

    budget = budget_of(forecast)
    if budget is None:
        return
    begins = next((item.done_s for item in forecast.estimate.items if item.seq == first), 0.0)
    now = budget.against_plan(left, begins)
    if now is not None and now.lands.likely < now.reserve:
        raise LowBattery(
            f"the vehicle says that {left:.0%} of its battery is left, and this flight takes "
            f"{left - now.lands.likely:.1%}: {now.reserve:.0%} must be left after landing",
            hint="put in a charged one; or, if the vehicle has not noticed that one is in, begin with --anyway",
        )


class OutsideOwnFence(MissionError):
    """The vehicle's own fence would break the flight off."""


def await_home(vehicle: Vehicle, progress: Progress = silent) -> None:
    """Wait until a vehicle knows where it is; `progress` is told what it says meanwhile.

    Raises:
        NotReady, TimeUp: it does not come to know it in time.
    """
    state, until_s = vehicle.state, vehicle.line.now() + vehicle.ready_s
    hinders = ""
    try:
        while vehicle.home() is None:
            hinders = "; ".join(("the vehicle does not know yet where it is", *dict.fromkeys(state.warnings)))
            progress(0.0, hinders)
            if vehicle.line.now() > until_s:
                raise NotReady(f"not ready after {vehicle.ready_s:.0f} s: {hinders}", hint="has it GPS reception?")
            state.warnings.clear()
    except TimeUp as late:
        raise TimeUp(f"{late}: {hinders}" if hinders else str(late), late.hint) from None


def expect_fit(vehicle: Vehicle, mission: Mission, anyway: bool = False) -> tuple[str, ...]:
    """Check a mission as this vehicle would meet it. Nothing is sent.

    Args:
        vehicle: at the other end of a link, as `connect` finds it.
        mission: what it is to fly.
        anyway: what fails a check is among the remarks, but a version that was not measured.

    Returns:
        Remarks for the user.

    Raises:
        Unsafe, FarFromHome, OutsideOwnFence: it would crash, be refused or be broken off.
        MissionError: it was made for another autopilot.

    Example:
        >>> from ipoa_mission import connect, expect_fit, read_mission
        >>> with connect("udpin:127.0.0.1:14550") as vehicle:
        ...     expect_fit(vehicle, read_mission("missions/sitl.plan"))
        ()
    """
    if mission.autopilot is not vehicle.autopilot and not anyway:
        raise MissionError(
            f"the mission was made for {mission.autopilot}, and the vehicle is {vehicle.autopilot}: "
            "its path and its time would be others",
            hint=f"make it for {vehicle.autopilot} (--autopilot {vehicle.autopilot}), or send it with --anyway",
            code="other-autopilot",
        )
    aboard, unsaid = check_aboard(mission, vehicle.autopilot, vehicle.firmware_version())
    findings = (*unsaid, *check_mission(aboard))
    refuse_errors([finding for finding in findings if not anyway or finding.code == NOT_MEASURED])
    there = _home_of(vehicle)
    return (
        *_compare_home(mission, there, anyway),
        *_compare_fence(mission, vehicle, there, anyway),
        *(finding.message for finding in findings),
    )


def _compare_fence(mission: Mission, vehicle: Vehicle, there: Geodetic | None, anyway: bool) -> tuple[str, ...]:
    """Hold the mission against the fence that the vehicle has by its own parameters."""
    try:
        fence = vehicle.autopilot.own_fence(vehicle.parameters(vehicle.autopilot.own_fence_by))
    except NoAnswer:
        return ("the vehicle does not tell whether it has a fence of its own: nobody compared the mission with it",)
    if fence is None or refusals(mission):
        return ()
    wrong = breaches(replace(mission, autopilot=vehicle.autopilot), fence, there or mission.home)
    if wrong and not anyway:
        raise OutsideOwnFence("\n".join(wrong), hint=vehicle.autopilot.protocol_profile.widen_fence)
    return wrong


def _home_of(vehicle: Vehicle) -> Geodetic | None:
    try:
        return vehicle.home()
    except NoAnswer:
        return None


def _compare_home(mission: Mission, there: Geodetic | None, anyway: bool) -> tuple[str, ...]:
    if there is None:
        return ("the vehicle does not say where its home is: nobody compared it with the mission's",)
    log.info("the vehicle's home: %.6f, %.6f, %.1f m AMSL", there.latitude_deg, there.longitude_deg, there.altitude)
    remarks = compare_homes(mission, there, anyway)
    wrong = refusals(replace(mission, home=replace(there, altitude=mission.home.altitude)))
    if wrong and not anyway:
        raise Unsafe("\n".join(f"from where the vehicle stands: {words}" for words in wrong))
    return (*remarks, *wrong)
