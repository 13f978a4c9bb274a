"""An open mission for the page: its items, what the check finds, and its flight as expected."""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from ipoa_mission.centimeters import down, up
from ipoa_mission.checks.firmware import is_too_long
from ipoa_mission.checks.positions import refusals
from ipoa_mission.errors import MissionError
from ipoa_mission.finding import Finding
from ipoa_mission.forecast.energy import budget_of
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.legs import item_places
from ipoa_mission.forecast.itinerary.program import as_flown
from ipoa_mission.mission.commands import Command
from ipoa_mission.mission.firmware import values_of
from ipoa_mission.mission.item_edits import complex_at
from ipoa_mission.mission.items import Item, Mission
from ipoa_mission.mission.mission_file import MissionFile
from ipoa_mission.mission.words import item_words
from ipoa_mission.report import seen
from ipoa_mission.scenario import Scenario
from ipoa_mission.scenario.places import FenceSection
from ipoa_mission.studio import answers
from ipoa_mission.studio.dropped import fences_of
from ipoa_mission.studio.item_fields import kind_of, kinds_of
from ipoa_mission.studio.mission_answers import Checked, Flaw, MissionItem, OpenMission
from ipoa_mission.studio.planned import SAMPLES, beside_course, course_of, homeward, near_things, slow_items
from ipoa_mission.studio.view import degree_of, fence_of, on_map, without_folders, world_of
from ipoa_mission.studio.vocabulary import Number
from ipoa_mission.vehicles.autopilot import registered
from ipoa_mission.world.airspace import Airspace, Bounds
from ipoa_mission.world.frame import LocalFrame
from ipoa_mission.world.terrain import Flat

ROOM = 0.25  # about the mission's places that the map shows, as a share of how far they reach
LEAST_ROOM = 60.0  # [m]
NOWHERE_NEAR = 1e7  # the bounds of a world of which nothing is known [m]


def opened(
    file: MissionFile, forecast: Forecast, revision: int, worlds: Sequence[str], world: str | None
) -> OpenMission:
    """The mission item by item."""
    mission = forecast.given
    firmware = mission.autopilot.firmware(mission.firmware_version)
    kinds = {kind.command: kind for kind in kinds_of(firmware)}
    for item in mission.items:
        kinds.setdefault(item.command, kind_of(item.command, item.has_position))
    parts = complex_at(mission)
    return OpenMission(
        revision=revision,
        autopilot=str(mission.autopilot),
        autopilots=tuple(str(one) for one in registered()),
        firmware=mission.autopilot.checked_for(mission.firmware_version),
        scenario=world,
        worlds=tuple(worlds),
        items=tuple(_item(seq, item, mission, parts[seq - 1]) for seq, item in enumerate(mission.items, start=1)),
        kinds=tuple(kinds.values()),
        lost=tuple(finding.message for finding in file.findings),
    )


def _item(seq: int, item: Item, mission: Mission, part: range | None) -> MissionItem:
    placed = item.command in mission.autopilot.firmware(mission.firmware_version).placed
    on_it = placed and (item.latitude_deg, item.longitude_deg) != (0.0, 0.0)
    place = (round(item.longitude_deg, 7), round(item.latitude_deg, 7)) if on_it else None
    return MissionItem(
        seq=seq,
        command=item.command,
        words=item_words(item),
        frame=item.frame,
        values=tuple(map(_known, values_of(item))),
        place=place,
        up=_known(mission.altitude_above_home(item)) if placed else None,
        part_of=None if part is None else (part.start, part.stop - 1),
    )


def _known(value: float) -> Number:
    return round(value, 9) if math.isfinite(value) else None


def mission_world(forecast: Forecast, revision: int) -> answers.World:
    """The map of a mission: that of the scenario in which it is judged, with the mission's home; else an empty one."""
    mission, scenario = forecast.given, forecast.scenario
    home = mission.home
    here = round(home.longitude_deg, 7), round(home.latitude_deg, 7)
    spot = answers.Spot(name="home", path=("home",), place=here, up=0.0, above_ground=0.0)
    frame = LocalFrame(home)
    fences = tuple(fence_of(n, FenceSection.model_validate(one), frame) for n, one in enumerate(fences_of(mission)))
    if scenario is not None and scenario.why_elsewhere(home) is None:
        world = world_of(scenario, revision)
        bodies = tuple(body.model_copy(update={"path": None}) for body in world.bodies)
        return world.model_copy(update={"spots": (spot,), "bodies": bodies, "fences": fences})
    places = [place[:2] for place in item_places(mission, frame, forecast.ground) if place is not None]
    points = np.array([np.zeros(2), *places])
    points = points[np.isfinite(points).all(axis=1) & (np.abs(points) < NOWHERE_NEAR / 10).all(axis=1)]
    room = max(LEAST_ROOM, ROOM * float(np.ptp(points, axis=0).max()))
    low, high = points.min(axis=0) - room, points.max(axis=0) + room
    rim = np.array([low, (high[0], low[1]), high, (low[0], high[1])])
    (west, south), _, (east, north), _ = around = on_map(frame, rim)
    return answers.World(
        revision=revision,
        box=(west, south, east, north),
        around=around,
        degree_m=degree_of(frame),
        floor=0.0,
        ceiling=500.0,
        bodies=(),
        spots=(spot,),
        fences=fences,
        ground=(),
        heights=answers.Heights(corner=(west, south), step=(1.0, 1.0), columns=1, up=()),
        home_amsl=home.altitude,
        required=0.0,
        remarks=(),
    )


def checked(findings: Sequence[Finding], forecast: Forecast, revision: int) -> tuple[Checked, bool]:
    """What the check finds, and whether the mission has a flight to be shown."""
    mission, scenario = forecast.given, forecast.scenario
    flaws = tuple(
        Flaw(
            severity=finding.severity.value,
            seq=finding.seq,
            words=_words(finding.message, scenario),
            hint=finding.hint and _words(finding.hint, scenario),
        )
        for finding in findings
    )
    why: str | None = None
    if not mission.items:
        why = "it has no item"
    elif refusals(mission):
        why = "a position or a height makes no sense"
    elif is_too_long(mission):
        why = "its vehicle holds fewer items"
    elif scenario is not None and scenario.why_elsewhere(mission.home) is not None:
        why = "it is of another place than the scenario"
    else:
        try:
            if not len(forecast.estimate.track.times) > 1:
                why = "nothing in it moves the vehicle"
        except MissionError as error:
            why = str(error)
    remarks = () if scenario is None else tuple(without_folders(words, scenario) for words in scenario.remarks)
    return Checked(revision=revision, flaws=flaws, timeless=why, remarks=remarks), why is None


def _words(words: str, scenario: Scenario | None) -> str:
    return words if scenario is None else without_folders(words, scenario)


def expected(forecast: Forecast, name: str, revision: int, took_s: float) -> answers.Plan:
    """The flight of a mission as expected; what it keeps only where a scenario says what stands there."""
    scenario, estimate = forecast.scenario, forecast.estimate
    nowhere = Airspace(Bounds((-NOWHERE_NEAR,) * 3, (NOWHERE_NEAR,) * 3), Flat())
    course = seen.follow(estimate.track, nowhere if scenario is None else scenario.airspace, SAMPLES)
    promise = None if scenario is None else forecast.promise_if_known
    kept = None if promise is None else promise.clearance
    budget = budget_of(forecast) if forecast.energy is not None else None
    left = None if budget is None else budget.left(budget.used.between)
    rim = None if scenario is None or promise is None else seen.tube_of(forecast)
    ring = [] if rim is None else seen.outline_round(course.points, rim.level)
    near = () if scenario is None else near_things(promise, course, scenario)
    return answers.Plan(
        of="mission",
        revision=revision,
        name=name,
        proof="",
        verdict="" if scenario is None or not forecast.cruise else _words(forecast.proof.words(), scenario),
        confidence=None if promise is None else promise.confidence,
        kept=None if kept is None else down(kept.kept),
        nominal=None if kept is None else down(kept.nominal),
        required=0.0 if scenario is None else up(scenario.limits.obstacle_distance if kept is None else kept.required),
        nearest="" if kept is None else _words(kept.to, scenario),
        total_s=round(estimate.total_s, 2),
        low_s=round(estimate.low_s, 2),
        high_s=round(estimate.high_s, 2),
        length=round(float(course.along[-1]), 1),
        energy_wh=None if budget is None else round(budget.used.energy_wh, 2),
        battery_left=None if left is None else round(left.likely, 3),
        tube_ring=tuple(on_map(forecast.frame, one) for one in ring),
        course=course_of(course, forecast),
        beside=() if scenario is None else tuple(beside_course(course, scenario)),
        stops=tuple(_stops(forecast, course)),
        bindings=(*near, *slow_items(estimate, course)),
        homeward=() if promise is None else homeward(forecast),
        choices=(),
        limits=(),
        warnings=(),
        remarks=tuple(estimate.remarks),
        took_s=round(took_s, 2),
    )


def _stops(forecast: Forecast, course: seen.Seen) -> Iterator[answers.Stop]:
    """Every item in the order flown; one that a jump leads to again comes again."""
    flown, scenario = as_flown(forecast.mission), forecast.scenario
    over = forecast.ground if scenario is None else scenario.airspace.ground
    places = item_places(flown, forecast.frame, over)
    for time in forecast.estimate.items:
        place = places[time.seq - 1]
        if place is not None and flown.items[time.seq - 1].command == Command.NAV_LAND:
            place[2] = over(place[None, :])[0]
        yield answers.Stop(
            seq=time.seq,
            at=course.nearest(time.done_s),
            words=item_words(flown.items[time.seq - 1]),
            done_s=round(time.done_s, 1),
            duration_s=round(time.duration_s, 1),
            place=None if place is None else on_map(forecast.frame, place[None, :])[0],
            up=None if place is None else round(float(place[2]), 1),
            above_ground=None
            if place is None or scenario is None
            else round(float(place[2] - over(place[None, :])[0]), 1),
        )
