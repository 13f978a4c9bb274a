import math
from collections.abc import Sequence

import numpy as np

from ipoa_mission.autopilot.autopilot import registered
from ipoa_mission.checks.firmware_check import is_too_long
from ipoa_mission.checks.positions import refusals
from ipoa_mission.errors import MissionError
from ipoa_mission.finding import Finding
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.flown_legs import item_places
from ipoa_mission.mission.item_edits import complex_at
from ipoa_mission.mission.item_words import item_words
from ipoa_mission.mission.items import Item, Mission
from ipoa_mission.mission.mission_file import MissionFile
from ipoa_mission.mission.stored_mission import values_of
from ipoa_mission.scenario import Scenario
from ipoa_mission.scenario.place_sections import FenceSection
from ipoa_mission.studio import answers
from ipoa_mission.studio.dropped import fences_of
from ipoa_mission.studio.item_fields import kind_of, kinds_of
from ipoa_mission.studio.mission_answers import Checked, Flaw, MissionItem, OpenMission
from ipoa_mission.studio.plan_answers import UNKNOWN_EXTENT
from ipoa_mission.studio.view import degree_of, fence_of, on_map, without_folders, world_of
from ipoa_mission.studio.vocabulary import Number
from ipoa_mission.world.frame import LocalFrame

MAP_MARGIN = 0.25  # of the places' extent
LEAST_MAP_MARGIN = 60.0  # [m]


def opened(
    file: MissionFile, forecast: Forecast, revision: int, worlds: Sequence[str], world: str | None
) -> OpenMission:
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
    """Return the scenario's map with the mission's home, else an empty one."""
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
    points = points[np.isfinite(points).all(axis=1) & (np.abs(points) < UNKNOWN_EXTENT / 10).all(axis=1)]
    room = max(LEAST_MAP_MARGIN, MAP_MARGIN * float(np.ptp(points, axis=0).max()))
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
        why = "a position or a height is not valid"
    elif is_too_long(mission):
        why = "its vehicle holds fewer items"
    elif scenario is not None and scenario.why_elsewhere(mission.home) is not None:
        why = "it is at another place than the scenario"
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
