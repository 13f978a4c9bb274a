from collections.abc import Iterator, Sequence
from dataclasses import replace

from ipoa_mission.autopilot.commands import JUMPS, LANDINGS, WAYPOINTS, Command, Frame
from ipoa_mission.checks.check import check
from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.finding import Severity
from ipoa_mission.forecast.contingency.energy_budget import budget_of, refusal_of
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import Item, Mission, camera_trigger, longest_part, return_to_launch, waypoint
from ipoa_mission.scenario import Scenario

# These lead elsewhere than to the next item.
NOT_SPLITTABLE = JUMPS | {
    Command.JUMP_TAG, Command.DO_LAND_START, Command.DO_RETURN_PATH_START, Command.NAV_ARC_WAYPOINT,
}  # fmt: skip
# In force until another of their kind.
STATES = frozenset({
    Command.DO_SET_CAM_TRIGG_DIST, Command.DO_SET_CAM_TRIGG_INTERVAL, Command.DO_SET_ROI_LOCATION, Command.DO_SET_ROI,
    Command.NAV_ROI, Command.DO_SET_ROI_NONE, Command.DO_MOUNT_CONTROL, Command.DO_GIMBAL_MANAGER_PITCHYAW,
    Command.CONDITION_YAW,
})  # fmt: skip


def split_by_battery(mission: Mission, scenario: Scenario) -> tuple[Mission, ...]:
    """Split a mission into the fewest flights that one battery each completes.

    Args:
        mission: a take-off, then waypoints, then its ending.
        scenario: its battery and world.

    Returns:
        The mission itself if one battery is enough, else its parts in order.

    Raises:
        BadInput: the scenario has no battery, or the vehicle's power is unknown.
        NotEnoughBattery: a waypoint is too far for one battery.
        MissionError: it jumps, begins in the air, or there is no clear way home, or back, at a waypoint.

    Example:
        >>> from ipoa_mission import read_mission, read_scenario, split_by_battery
        >>> airframe = {"mass_kg": 3.0, "rotor_diameter": 0.35}
        >>> scenario = read_scenario("missions/campus.toml")
        >>> battery = {"capacity_wh": 100.0}
        >>> vehicle = type(scenario.vehicle)(autopilot="ardupilot", airframe=airframe, battery=battery)
        >>> enough = scenario.model_copy(update={"vehicle": vehicle})
        >>> len(split_by_battery(read_mission("missions/campus.plan"), enough))
        1
    """
    return tuple(flight.mission_as_read for flight in split_flight(Forecast(mission, scenario)))


def split_flight(whole: Forecast) -> tuple[Forecast, ...]:
    """Return the forecasts of the parts; raise errors as `split_by_battery`."""
    budget = budget_of(whole)
    if budget is None or budget.battery is None:
        words = "expected a battery, and an airframe or a learned vehicle, to split a mission"
        raise BadInput(words, code="battery-missing", place="vehicle.battery")
    if budget.refusal is None:
        return (whole,)
    parts = _Parts(whole)
    flights = list[Forecast]()
    begin = 0
    legs = 1
    while begin < parts.last:
        end, flight = parts.longest(begin, legs)
        flights.append(flight)
        legs = end - begin
        begin = end
    return tuple(flights)


class _Parts:
    def __init__(self, whole: Forecast) -> None:
        self.whole = whole
        self.mission = whole.mission_as_read
        items = self.mission.items
        begins = [n for n, item in enumerate(items) if item.is_takeoff]
        if len(begins) != 1 or any(item.command in NOT_SPLITTABLE for item in items):
            raise MissionError("expected one take-off and no jumps or arcs in a mission to split", code="not-split")
        self.start = begins[0] + 1
        # a flight may turn home or resume there
        waypoints = [n for n, item in enumerate(items) if item.command in WAYPOINTS and item.has_position]
        self.turns = [n for n in waypoints if n >= self.start]
        self.last = len(self.turns)

    def longest(self, begin: int, guess: int) -> tuple[int, Forecast]:
        """Return the farthest end of a flight from waypoint `begin`, and that flight."""
        straight = dict[int, Forecast]()

        def fits(waypoints: int) -> bool:
            straight[begin + waypoints] = flight = self.part(begin, begin + waypoints)
            return refusal_of(flight) is None

        reached = begin + longest_part(fits, self.last - begin, guess)
        if reached == begin:
            short = refusal_of(straight[begin + 1])
            assert short is not None
            raise short.at(f"item {self.turns[begin] + 1} is too far for one battery")
        why: MissionError | None = None
        for end in range(reached, begin, -1):
            for path in self._paths_back(begin):
                flight = (None if path else straight.get(end)) or self.part(begin, end, path)
                if (refused := _refused(flight)) is None:
                    return end, flight
                why = why or refused
        assert why is not None
        raise why

    def part(self, begin: int, end: int, path: Sequence[Item] = ()) -> Forecast:
        items = self.mission.items
        until = len(items) if end == self.last else self.turns[end - 1] + 1
        kept = list(items[:until])
        if begin > 0:
            at = self.turns[begin - 1]
            before = items[self.start : at]
            speeds = [item for item in before if item.command == Command.DO_CHANGE_SPEED][-1:]
            kept = [*items[: self.start], *speeds, *path, items[at], *_in_force(before), *items[at + 1 : until]]
        if end < self.last or not any(item.command in LANDINGS for item in kept):
            kept += [*_ended(kept), return_to_launch()]
        return Forecast(replace(self.mission, items=tuple(kept)), self.whole.scenario)

    def _paths_back(self, begin: int) -> Iterator[tuple[Item, ...]]:
        """Yield paths to the resumed waypoint: straight, then as high as an RTL."""
        yield ()
        if begin > 0:
            frame = self.whole.frame
            item = self.mission.items[self.turns[begin - 1]]
            home = self.mission.home
            where = Geodetic(item.latitude_deg, item.longitude_deg, home.altitude + item.height(home))
            over, over_home = self.whole.returns_from(frame.local(where)[None])[0, 0, 1:]
            high = (frame.geodetic(point) for point in (over_home, over))
            defaults = self.mission.autopilot.waypoint_defaults(self.mission.firmware_version)
            yield tuple(waypoint(place, place.altitude - home.altitude, *defaults) for place in high)


def _refused(flight: Forecast) -> MissionError | None:
    errors = [finding for finding in check(flight) if finding.severity is Severity.ERROR]
    return MissionError(errors[0].message, hint=errors[0].hint) if errors else None


def _in_force(before: Sequence[Item]) -> Iterator[Item]:
    last = {item.command: n for n, item in enumerate(before) if item.command in STATES}
    yield from (before[n] for n in sorted(last.values()))


def _ended(items: Sequence[Item]) -> Iterator[Item]:
    triggers = [item for item in items if item.command == Command.DO_SET_CAM_TRIGG_DIST]
    if triggers and triggers[-1].params[0] > 0.0:
        yield camera_trigger(0.0, at_once=False)
    pictures = (Command.IMAGE_START_CAPTURE, Command.IMAGE_STOP_CAPTURE)
    captures = [item.command for item in items if item.command in pictures]
    if captures and captures[-1] == Command.IMAGE_START_CAPTURE:
        yield Item(Command.IMAGE_STOP_CAPTURE, Frame.MISSION)
