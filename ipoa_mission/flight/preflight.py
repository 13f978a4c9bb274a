import logging
import math
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import compress
from types import MappingProxyType

import numpy as np

from ipoa_mission.autopilot.commands import Frame, plain_frame
from ipoa_mission.autopilot.failsafe import FenceLimit, FlightStage, OwnFence
from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.autopilot.version import Version
from ipoa_mission.checks.check import check_mission
from ipoa_mission.checks.firmware_check import check_aboard
from ipoa_mission.checks.unsafe import HOME_RADIUS, NotAtStart, refuse_errors
from ipoa_mission.errors import MissionError, Unsafe
from ipoa_mission.forecast.deviation.law import law_of
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.flown_legs import Leg
from ipoa_mission.forecast.leg_limits import landings
from ipoa_mission.geodesy import Geodetic, apart
from ipoa_mission.link.dialogue import NoAnswer, TimeUp
from ipoa_mission.link.messages import STATION_SYSTEM, Position
from ipoa_mission.link.vehicle import Vehicle
from ipoa_mission.link.vehicle_state import NotReady
from ipoa_mission.mission.items import Mission, item_of
from ipoa_mission.mission.positions import refusals
from ipoa_mission.progress import Progress, silent

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class OtherValue:
    """A parameter's values in mission and vehicle, by the vehicle's name."""

    name: str
    wanted: float
    has: float

    def __str__(self) -> str:
        return f"{self.name} is {self.has:g} on the vehicle, and the mission was made for {self.wanted:g}"


def other_values(vehicle: Vehicle, wanted: Parameters) -> tuple[tuple[OtherValue, ...], tuple[str, ...]]:
    """Return differing values, and parameters that the vehicle lacks."""
    spelled = vehicle.autopilot.parameter_table.spellings
    values = vehicle.parameters([name for name, _ in spelled(parameter)] for parameter in wanted) if wanted else {}
    differing = []
    missing = []
    for parameter, value in wanted.items():
        for name, unit in spelled(parameter):
            if name in values:
                if not abs(values[name] - value * unit) <= 1e-6 * max(1.0, abs(value * unit)):  # single; NaN differs
                    differing.append(OtherValue(name, value * unit, values[name]))
                break
        else:
            missing.append(parameter)
    return tuple(differing), tuple(missing)


@dataclass(frozen=True)
class ParametersAboard:
    """The vehicle's values that differ from a mission's, and from the defaults that its forecast assumes.

    Attributes:
        named: differ from the mission's.
        assumed: differ from defaults.
        missing: the mission's parameters that the vehicle lacks.
    """

    named: tuple[OtherValue, ...] = ()
    assumed: tuple[OtherValue, ...] = ()
    missing: tuple[str, ...] = ()

    @property
    def values(self) -> dict[str, float]:
        return {other.name: other.has for other in (*self.named, *self.assumed)}

    @property
    def remedies(self) -> tuple[str, ...]:
        own = ", ".join(f"{other.name} = {other.has:g}" for other in self.assumed)
        return (
            *(["write the mission's parameters with --set-params"] if self.named else []),
            *([f"plan with {own} under [vehicle.parameters]"] if own else []),
        )

    def remarks(self, remedy: str = "") -> tuple[str, ...]:
        own = ", ".join(f"{other.name} {other.has:g} (not {other.wanted:g})" for other in self.assumed)
        return (
            *(f"{other}{remedy}" for other in self.named),
            *([f"the mission assumes default parameters, and the vehicle has {own}"] if own else []),
            *(f"the vehicle has no parameter {name}" for name in self.missing),
        )


def parameters_aboard(vehicle: Vehicle, mission: Mission) -> ParametersAboard:
    """Compare all parameters that a forecast uses, its contingencies and fences included."""
    table = vehicle.autopilot.parameter_table
    assumed: Parameters = {}
    if mission.autopilot is vehicle.autopilot:
        assumed = vehicle.autopilot.assumed_parameters(vehicle.firmware_version())
    differing, missing = other_values(vehicle, table.overridden(assumed, mission.parameters))
    named = table.by_old_names(mission.parameters).keys()
    is_named = [bool(table.by_old_names({other.name: 0.0}).keys() & named) for other in differing]
    return ParametersAboard(
        tuple(compress(differing, is_named)),
        tuple(other for other, by_mission in zip(differing, is_named, strict=True) if not by_mission),
        tuple(name for name in missing if name in mission.parameters),
    )


def without_station(vehicle: Vehicle, version: Version | None = None) -> str:
    """Return the action after a loss of this station, "" if unknown; default: newest measured version."""
    loss = vehicle.autopilot.failsafe_profile.station_loss
    if loss is None:
        return ""
    values = vehicle.parameters(loss.decided_by)
    return loss.words(vehicle.autopilot.failsafes(values, version), values, STATION_SYSTEM)


def idle_fence(vehicle: Vehicle, mission: Mission) -> tuple[str, ...]:
    if not mission.fence:
        return ()
    switch = vehicle.autopilot.parameter_table.by_meaning["fence switch"].name
    if vehicle.parameters([switch]).get(switch, 1.0) != 0.0:
        return ()
    bits = vehicle.autopilot.protocol_profile.limits_are_bits
    more = f"; {bits} chooses the enabled limits: 4 is this fence alone" if bits else ""
    return (f"the fence does nothing on this vehicle: its {switch} is 0{more}",)


class FarFromHome(MissionError, code="far-from-home"):
    """Heights above home would refer to other ground: the vehicle's home is over `reach` away, or `rise` higher [m]."""

    reach = 100.0
    rise = 15.0


def expect_same_height(home: Geodetic, vehicle_home: Geodetic | None) -> None:
    if vehicle_home is None:
        return
    if apart(home, vehicle_home) <= FarFromHome.reach and abs(vehicle_home.altitude - home.altitude) > FarFromHome.rise:
        words = f"expected the vehicle's home at {home.altitude:.1f} m AMSL, not {vehicle_home.altitude:.1f} m"
        raise FarFromHome(words, hint="heights count from the vehicle's home: plan from its position, or use --anyway")


def expect_home_here(position: Position | None, home: Geodetic) -> None:
    """Raise NotAtStart if a vehicle on the ground at the mission's home counts heights from elsewhere."""
    if position is None or apart(Geodetic(position.latitude_deg, position.longitude_deg), home) > HOME_RADIUS:
        return
    if abs(position.height) > 3.0:  # [m]
        words = f"expected the vehicle on the ground at the height of its home, not at {position.height:+.1f} m"
        raise NotAtStart(words, hint="heights count from its home: restart it here; or begin with --anyway")


class FastLanding(MissionError, code="fast-landing"):
    """The vehicle's own parameters make a fast touchdown."""


def expect_slow_landing(forecast: Forecast, aboard: Forecast) -> None:
    """Raise FastLanding if a landing is fast only with the parameters `aboard`."""
    autopilot = forecast.mission.autopilot
    planned = autopilot.slow_stretch(forecast.mission.parameters)
    actual = autopilot.slow_stretch(aboard.mission.parameters)
    if planned is None or actual is None or forecast.ground.is_flat:
        return
    for landing in landings(forecast):
        height = landing.assumed_height
        if actual.is_fast(height) and not planned.is_fast(height):
            raise FastLanding(
                f"{landing.words}: with the vehicle's own parameters, {landing.touches_down(actual)}",
                hint="set the mission's parameters (NAME.params) by `fly --set-params`; "
                "--anyway flies with the vehicle's own",
            )


class LowBattery(MissionError, code="low-battery"):
    """Too little battery for the flight and its reserve."""


def expect_charge(vehicle: Vehicle, forecast: Forecast, first: int = 0) -> tuple[str, ...]:
    """Raise LowBattery if less than the scenario's reserve remains; begin at item `first`. Return remarks."""
    if forecast.scenario is None:
        return ()
    from ipoa_mission.forecast.contingency.energy_budget import budget_of

    budget = budget_of(forecast)
    left = vehicle.state.battery_left
    if budget is None or budget.battery is None:
        return ()
    if left is None:
        return ("the battery was not compared with this flight: the vehicle reports no charge",)
    begins = next((item.done_s for item in forecast.estimate.items if item.seq == first), 0.0)
    now = budget.against_plan(left, begins)
    if now is not None and now.lands.likely < now.reserve - 1e-9:  # rounding
        raise LowBattery(
            f"the vehicle reports {left:.0%} of its battery, and this flight takes "
            f"{left - now.lands.likely:.1%}: {now.reserve:.0%} must be left after landing",
            hint="insert a charged battery; or, if it is charged and the vehicle does not report it, use --anyway",
        )
    return ()


class OutsideOwnFence(MissionError, code="outside-own-fence"):
    """The vehicle's own fence would abort the flight."""


def await_home(vehicle: Vehicle, progress: Progress = silent) -> None:
    until_s = vehicle.connection.now() + vehicle.ready_s
    reason = ""
    try:
        while vehicle.home() is None:
            reason = "; ".join(("the vehicle has no position yet", *vehicle.state.warnings.words))
            progress(0.0, reason)
            if vehicle.connection.now() > until_s:
                raise NotReady(f"not ready after {vehicle.ready_s:.0f} s: {reason}", hint="check its GPS reception")
            vehicle.state.warnings.words.clear()
    except TimeUp as late:
        raise TimeUp(f"{late}: {reason}" if reason else str(late), late.hint) from None


def expect_fit(
    vehicle: Vehicle,
    mission: Mission,
    anyway: bool = False,
    ignore: Iterable[str] = (),
    written: Parameters = MappingProxyType({}),
) -> tuple[str, ...]:
    """Check a mission against this vehicle; send nothing.

    Args:
        vehicle: from `connect`.
        mission: to fly.
        anyway: return failed checks as remarks, except an unmeasured firmware version.
        ignore: codes of findings to leave out.
        written: values by the vehicle's names, as if aboard.

    Returns:
        Remarks for the user.

    Raises:
        Unsafe, FarFromHome, OutsideOwnFence: it would crash, be refused or be aborted.
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
            "its path and its time would differ",
            hint=f"make it for {vehicle.autopilot} (--autopilot {vehicle.autopilot}), or send it with --anyway",
            code="other-autopilot",
        )
    aboard, remarks_aboard = check_aboard(mission, vehicle.autopilot, vehicle.firmware_version())
    findings = (*remarks_aboard, *check_mission(aboard, ignore=ignore))
    refuse_errors([finding for finding in findings if not anyway or finding.code == "version-not-measured"])
    vehicle_home = None
    with suppress(NoAnswer):
        vehicle_home = vehicle.home()
    is_other = mission.firmware_version is not None and str(mission.firmware) != str(aboard.firmware)
    return (
        *([f"the mission was made for {mission.firmware}, and the vehicle has {aboard.firmware}"] if is_other else []),
        *_compare_home(mission, vehicle_home, anyway),
        *_compare_fence(mission, vehicle, vehicle_home, anyway, written),
        *(finding.message for finding in findings),
    )


def _compare_fence(
    mission: Mission, vehicle: Vehicle, vehicle_home: Geodetic | None, anyway: bool, written: Parameters
) -> tuple[str, ...]:
    try:
        fence = vehicle.autopilot.own_fence({**vehicle.parameters(vehicle.autopilot.own_fence_by), **written})
    except NoAnswer:
        return ("the vehicle does not report its own fence: the mission was not compared with it",)
    if fence is None:
        return ()
    unsafe = refusals(mission)
    if unsafe:
        return (f"the mission was not compared with the vehicle's own fence: {'; '.join(unsafe)}",)
    wrong = breaches(replace(mission, autopilot=vehicle.autopilot), fence, vehicle_home or mission.home)
    if wrong and not anyway:
        raise OutsideOwnFence("\n".join(wrong), hint=vehicle.autopilot.protocol_profile.widen_fence)
    return wrong


def _compare_home(mission: Mission, vehicle_home: Geodetic | None, anyway: bool) -> tuple[str, ...]:
    """Refuse a far home, if heights count from it."""
    if vehicle_home is None:
        return ("the vehicle does not report its home: it was not compared with the mission's",)
    log.info(
        "the vehicle's home: %.6f, %.6f, %.1f m AMSL",
        vehicle_home.latitude_deg,
        vehicle_home.longitude_deg,
        vehicle_home.altitude,
    )
    home = mission.home
    remarks = list[str]()
    distance = apart(home, vehicle_home)
    higher = vehicle_home.altitude - home.altitude
    if distance > FarFromHome.reach:
        away = f"{distance:.0f} m" if distance < 10_000 else f"{distance / 1000:.0f} km"
        words = (
            f"the vehicle's home is {away} from the mission's: it is at {vehicle_home.latitude_deg:.5f}, "
            f"{vehicle_home.longitude_deg:.5f}, and the mission takes off at {home.latitude_deg:.5f}, "
            f"{home.longitude_deg:.5f}"
        )
        placed = (item for item in mission.items if item.has_position)
        if not anyway and any(plain_frame(item.frame) == Frame.GLOBAL_RELATIVE_ALT for item in placed):
            raise FarFromHome(
                words,
                hint="heights count from the vehicle's home: plan from its position, or send with --anyway. "
                "A vehicle moved since its last arming sets its home there after a restart (the built-in autopilot "
                f"starts there with `mock --home {home.latitude_deg:.6f} {home.longitude_deg:.6f} "
                f"{home.altitude:.1f}`)",
            )
        remarks.append(words)
    elif math.isfinite(higher) and abs(higher) > 5.0:
        remarks.append(
            f"the vehicle's home is {abs(higher):.1f} m {'higher' if higher > 0 else 'lower'} than the mission's "
            f"({vehicle_home.altitude:.1f} m AMSL, not {home.altitude:.1f} m); heights count from the vehicle's"
        )
    wrong = refusals(replace(mission, home=replace(vehicle_home, altitude=home.altitude)))
    if wrong and not anyway:
        raise Unsafe("\n".join(f"from the vehicle's position: {words}" for words in wrong))
    return (*remarks, *wrong)


def breaches(mission: Mission, fence: OwnFence, vehicle_home: Geodetic) -> tuple[str, ...]:
    """Report each limit that a flight from `vehicle_home` would reach, with the furthest place."""
    law = law_of(mission.autopilot)
    share = 0.01  # of flights deviates farther
    forecast = Forecast(mission)
    center = forecast.frame.local(vehicle_home)[:2]
    legs = forecast.legs
    heights = [forecast.frame.to_geodetic(leg.points)[2] - mission.home.altitude for leg in legs]
    farthest = [(leg, float(np.hypot(*(leg.points[:, :2] - center).T).max())) for leg in legs]
    highest = [(leg, float(up.max())) for leg, up in zip(legs, heights, strict=True)]
    lowest = [(leg, float(up.min())) for leg, up in zip(legs, heights, strict=True) if leg.stage is FlightStage.ROUTE]
    return (
        *_beyond(mission, fence.radius, farthest, "away from home", law.lateral_bound(share)),
        *_beyond(mission, fence.ceiling, highest, "above home", law.highest.distance(share)),
        *_beyond(mission, fence.floor, lowest, "above home", -law.lowest.distance(share)),
    )


def _beyond(
    mission: Mission, limit: FenceLimit, reached: list[tuple[Leg, float]], where: str, deviation: float
) -> Iterator[str]:
    sign = math.copysign(1.0, deviation)
    leg, value = max(reached, key=lambda place: sign * place[1], default=(None, 0.0))
    if leg is None or sign * (value + deviation - limit.value) < 0.0:
        return
    allowed = f"{limit.value:.1f} m at {'least' if sign < 0.0 else 'most'} ({limit.name})"
    flown = f"{value:.1f} m {where} ({value + deviation:.1f} m with the deviation of flights)"
    after = f" on {leg.name}" if leg.jumped_from >= 0 else ""
    yield f"{item_of(mission, leg.seq)}: {flown}{after}, and the vehicle's own fence allows {allowed}"
