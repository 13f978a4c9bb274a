"""Compare a flown mission with its estimate, leg by leg between items that both have."""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from ipoa_mission.autopilot.commands import HOLDING, Command
from ipoa_mission.autopilot.learned import LearnedVehicle
from ipoa_mission.autopilot.parameters import Parameters
from ipoa_mission.autopilot.version import Version
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.timing.estimate import Estimate
from ipoa_mission.forecast.timing.track import Track
from ipoa_mission.logs.flight_log import LoggedFlight
from ipoa_mission.mission.flight_record import FlightRecord
from ipoa_mission.mission.items import Mission
from ipoa_mission.mission.stored_mission import compare, to_wire
from ipoa_mission.wind import CALM, Wind

NOTED_HOME_DRIFT = 0.5  # [m]


@dataclass(frozen=True)
class LegTime:
    """Estimated and flown time, since arming and since the leg before [s]."""

    seq: int
    command: int
    estimated_done_s: float
    flown_done_s: float
    estimated_s: float
    flown_s: float

    @property
    def error_s(self) -> float:
        """Estimated minus flown [s]."""
        return self.estimated_s - self.flown_s


@dataclass(frozen=True)
class Comparison:
    """A flight compared with its estimate.

    Attributes:
        legs: the estimated and flown time of each item [s].
        estimated_total_s: from arming to the end [s].
        flown_total_s: the same; NaN if the log ends before the flight does.
        estimated_route_s: from the first item with a place to the last, without the landing [s].
        flown_route_s: the same.
    """

    legs: tuple[LegTime, ...]
    estimated_total_s: float
    flown_total_s: float
    estimated_route_s: float
    flown_route_s: float

    @property
    def route_error(self) -> float:
        """Return the error as a share of the flown time; NaN without a flown route."""
        return self.estimated_route_s / self.flown_route_s - 1 if self.flown_route_s > 0 else math.nan

    @property
    def total_error(self) -> float:
        """Return the error as a share of the flown time."""
        return self.estimated_total_s / self.flown_total_s - 1 if self.flown_total_s > 0 else math.nan


def compare_flight(estimate: Estimate, flight: FlightRecord) -> Comparison:
    """Compare a flight with the estimate of its mission.

    Args:
        estimate: of the mission.
        flight: as flown; a repeated item counts at its first time.

    Returns:
        All legs and their totals.

    Example:
        >>> from ipoa_mission import compare_flight, estimate, fly_built_in, read_mission
        >>> mission = read_mission("missions/sitl.plan")
        >>> abs(compare_flight(estimate(mission), fly_built_in(mission)).route_error) < 0.05
        True
    """
    legs = dict[int, LegTime]()
    estimated = flown = 0.0
    for item in estimate.items:
        done = flight.timed_items_s.get(item.seq - 1)
        if done is not None and item.seq not in legs:
            takes = item.done_s - estimated, done - flown
            legs[item.seq] = LegTime(item.seq, item.command, item.done_s, done, *takes)
            estimated = item.done_s
            flown = done
    on_route = HOLDING | {Command.NAV_TAKEOFF}
    route = [leg for leg in legs.values() if leg.command in on_route]
    return Comparison(
        legs=tuple(legs.values()),
        estimated_total_s=estimate.total_s,
        flown_total_s=flight.total_s if flight.completed else math.nan,
        estimated_route_s=route[-1].estimated_done_s - route[0].estimated_done_s if route else math.nan,
        flown_route_s=route[-1].flown_done_s - route[0].flown_done_s if route else math.nan,
    )


@dataclass(frozen=True)
class Assumptions:
    """About a logged flight; `parameters` and `version` replace the log's."""

    parameters: Parameters = field(default_factory=dict)
    vehicle: LearnedVehicle | None = None
    wind: Wind = CALM
    version: Version | None = None


@dataclass(frozen=True)
class ComparedFlight:
    """`parameters` that differ from the firmware's defaults, by their names before 4.7."""

    forecast: Forecast
    record: FlightRecord
    comparison: Comparison
    parameters: Parameters
    remarks: tuple[str, ...]


def compare_logged(
    flight: LoggedFlight, mission: Mission | None = None, assumed: Assumptions | None = None
) -> ComparedFlight | None:
    """Compare with the estimate of `mission`, or of the logged mission, if known."""
    assumed = assumed or Assumptions()
    flown = mission or flight.mission
    if flown is None:
        return None
    flown = flown.with_parameters(flight.parameters).with_parameters(assumed.parameters)
    version = assumed.version or flight.firmware_version
    forecast = Forecast(replace(flown, vehicle=assumed.vehicle), wind=assumed.wind).on(version)
    record = flight.record(flown)
    remarks: list[str] = []
    if flight.mission is not None:
        difference = compare(to_wire(flown), to_wire(flight.mission), flight.autopilot)
        if difference is not None and difference.seq is None:  # without ArduPilot's home
            counts = f"{len(flight.mission.items)} in the log, not {len(flown.items)}"
            remarks.append(f"another mission was flown: number of items: {counts}")
        elif difference is not None:
            words = f"{difference.field}: {difference.got} in the log, not {difference.sent}"
            remarks.append(f"another mission was flown: item {difference.seq}: {words}")
    track = flown_track(forecast, record)
    from_home = 0.0 if track is None else math.hypot(*track.points[0, :2])  # [m]
    if from_home > 5.0:
        remarks.append(f"it was armed {from_home:.0f} m from the mission's home, where the estimate begins")
    if record.home_drift > NOTED_HOME_DRIFT:
        drift = f"{record.home_drift:.1f} m"
        remarks.append(f"home's altitude changed by up to {drift} in flight: heights count from that at arming")
    first = min(record.item_reached_s, default=0) + 1
    if first > 1:
        remarks.append(f"it began at item {first}")

    autopilot = forecast.mission.autopilot
    defaults = autopilot.complete({}, forecast.mission.firmware_version)
    current = autopilot.parameter_table.by_old_names(forecast.mission.parameters)
    changed = {
        name: current[name]
        for name in defaults
        if name in current and not math.isclose(current[name], defaults[name], rel_tol=1e-5)
    }
    return ComparedFlight(forecast, record, compare_flight(forecast.estimate, record), changed, tuple(remarks))


def flown_track(forecast: Forecast, flight: FlightRecord) -> Track | None:
    """In the forecast's frame."""
    if len(flight.path) < 2:
        return None
    positions = [(s.time_s, s.latitude_deg, s.longitude_deg, s.speed) for s in flight.path]
    times, latitude, longitude, speeds = np.array(positions).T
    points = forecast.frame.to_local(latitude, longitude, forecast.mission.home.altitude + np.array(flight.heights))
    return Track(times=times, points=points, speeds=speeds)
