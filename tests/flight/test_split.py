from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pytest

from ipoa_mission import split_by_battery
from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import Command, Frame
from ipoa_mission.checks.check import check_mission
from ipoa_mission.errors import BadInput
from ipoa_mission.finding import Severity
from ipoa_mission.forecast.contingency.energy_budget import budget_of
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.mission.items import Item, Mission, change_speed, return_to_launch, takeoff, waypoint
from ipoa_mission.scenario import Scenario
from tests.refused import refuses

HOME = {"latitude_deg": 47.397742, "longitude_deg": 8.545594, "altitude_amsl": 488.0}
TRIGGER = Item(Command.DO_SET_CAM_TRIGG_DIST, Frame.MISSION, (12.0, 0.0, 1.0, 0.0))
PLACES = [(east, north) for east in (40, 80, 120) for north in ((0, 150) if east % 80 else (150, 0))]


def world(capacity: float, *obstacles: dict[str, object]) -> Scenario:
    return Scenario.from_dict({
        "name": "strips",
        "home": HOME,
        "start": {"east": 0.0, "north": 0.0, "up": 15.0},
        "goal": {"east": 180.0, "north": 150.0, "up": 30.0},
        "obstacles": list(obstacles),
        "vehicle": {
            "autopilot": "ardupilot",
            "parameters": {"RTL_ALT": 4000.0},
            "airframe": {"mass_kg": 3.0, "rotor_diameter": 0.35},
            "battery": {"capacity_wh": capacity},
        },
    })  # fmt: skip


def strips(scenario: Scenario, up: float = 30.0, places: Sequence[tuple[int, int]] = PLACES) -> Mission:
    flown = [waypoint(scenario.frame.geodetic(np.array([east, north, 30.0])), 30.0) for east, north in places]
    items = (takeoff(scenario.frame.home, up), change_speed(6.0), flown[0], TRIGGER, *flown[1:], return_to_launch())
    return Mission(scenario.frame.home, items, Autopilot.ARDUPILOT)


def places_of(mission: Mission) -> list[Item]:
    return [item for item in mission.items if item.command == Command.NAV_WAYPOINT]


def test_each_part_comes_home_and_together_they_fly_all_of_it() -> None:
    scenario = world(22.0)
    mission = strips(scenario)
    parts = split_by_battery(mission, scenario)
    assert len(parts) > 1
    flown = [places_of(part) for part in parts]
    for own, following in pairwise(flown):
        assert own[-1] == following[0]  # continues where the other turned home
    assert [*flown[0], *(item for part in flown[1:] for item in part[1:])] == places_of(mission)
    for part in parts:
        budget = budget_of(Forecast(part, scenario))
        assert budget is not None
        assert budget.shortage is None
        assert not [finding for finding in check_mission(part, scenario) if finding.severity is Severity.ERROR]
        assert part.items[0].command == Command.NAV_TAKEOFF
        assert part.items[-1].command == Command.NAV_RETURN_TO_LAUNCH
        assert change_speed(6.0) in part.items
        assert TRIGGER in part.items
    for part in parts[:-1]:
        assert part.items[-2] == Item(Command.DO_SET_CAM_TRIGG_DIST, Frame.MISSION)  # no pictures on the way home


def test_the_fewest_flights_are_taken() -> None:
    """No flight could have gone on to the next waypoint: by the triangle's law none can be spared."""
    scenario = world(22.0)
    mission = strips(scenario)
    parts = split_by_battery(mission, scenario)
    places, reached = places_of(mission), 0
    for part in parts[:-1]:
        own = places_of(part)
        reached += len(own) - (1 if reached else 0)
        further = (*part.items[:-2], places[reached], return_to_launch())
        budget = budget_of(Forecast(Mission(mission.home, further, mission.autopilot), scenario))
        assert budget is not None
        assert budget.shortage is not None


def test_one_battery_that_is_enough_is_one_flight_and_none_is_refused() -> None:
    scenario = world(400.0)
    mission = strips(scenario)
    assert split_by_battery(mission, scenario) == (mission,)
    with refuses("not-enough-battery", "item 3 is too far for one battery: battery"):
        split_by_battery(mission, world(3.0))
    bare = scenario.model_copy(update={"vehicle": scenario.vehicle.model_copy(update={"battery": None})})
    with refuses("battery-missing", "vehicle.battery", kind=BadInput):
        split_by_battery(mission, bare)
    jump = Item(Command.DO_JUMP, Frame.MISSION, (3.0, 1.0, 0.0, 0.0))
    with refuses("not-split"):
        split_by_battery(
            Mission(mission.home, (*mission.items[:-1], jump, mission.items[-1]), mission.autopilot), world(22.0)
        )


def test_an_unclear_straight_approach_is_flown_at_the_return_altitude() -> None:
    """A wall between home and all places but the first, higher than the take-off and lower than the return."""
    wall = {"kind": "box", "name": "wall", "east": 10.0, "north": -10.0, "width": 6.0, "depth": 36.0, "height": 22.0}
    scenario = world(22.0, wall)
    mission = strips(scenario, 12.0, [(40, 150), *((east, 0) for east in (90, 150, 210))])
    parts = split_by_battery(mission, scenario)
    assert len(parts) > 1
    for part in parts[1:]:
        assert [item.altitude for item in places_of(part)[:2]] == pytest.approx([40.0, 40.0], abs=0.01)
        assert not [finding for finding in check_mission(part, scenario) if finding.severity is Severity.ERROR]
