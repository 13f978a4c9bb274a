import math
import re
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ipoa_mission.autopilot.autopilot import registered
from ipoa_mission.autopilot.commands import Command, short_name
from ipoa_mission.autopilot.firmware_tables import Firmware
from ipoa_mission.checks.firmware_check import is_too_long
from ipoa_mission.checks.positions import refusals
from ipoa_mission.errors import MissionError
from ipoa_mission.finding import Finding
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.flown_legs import item_places
from ipoa_mission.link.definitions import params_in_words
from ipoa_mission.mission.item_edits import complex_at
from ipoa_mission.mission.item_words import item_words
from ipoa_mission.mission.items import Item, Mission
from ipoa_mission.mission.mission_file import MissionFile
from ipoa_mission.mission.stored_mission import values_of
from ipoa_mission.scenario import Scenario
from ipoa_mission.scenario.place_sections import FenceSection
from ipoa_mission.studio import answers
from ipoa_mission.studio.dropped import fences_of
from ipoa_mission.studio.mission_answers import Checked, Flaw, ItemField, ItemKind, MissionItem, OpenMission
from ipoa_mission.studio.plan_answers import UNKNOWN_EXTENT
from ipoa_mission.studio.view import degree_of, fence_of, on_map, without_folders, world_of
from ipoa_mission.studio.vocabulary import Number
from ipoa_mission.world.frame import LocalFrame

LONGEST = 32  # letters
HOLD, HEADING = ("Stay for", "s"), ("Heading there", "°, empty: its own")
#: Label and unit by command; other params are shown if not zero.
OURS: Mapping[int, Mapping[int, tuple[str, str]]] = {
    Command.NAV_WAYPOINT: {1: HOLD, 2: ("Acceptance radius", "m"), 4: HEADING},
    Command.NAV_SPLINE_WAYPOINT: {1: HOLD},
    Command.NAV_ARC_WAYPOINT: {1: ("Turn by", "°")},
    Command.NAV_LOITER_UNLIM: {3: ("Radius", "m"), 4: HEADING},
    Command.NAV_LOITER_TURNS: {1: ("Turns", ""), 3: ("Radius", "m")},
    Command.NAV_LOITER_TIME: {1: HOLD, 3: ("Radius", "m")},
    Command.NAV_RETURN_TO_LAUNCH: {},
    Command.NAV_LAND: {4: HEADING},
    Command.NAV_TAKEOFF: {4: HEADING},
    Command.NAV_DELAY: {1: ("Wait for", "s")},
    Command.CONDITION_DELAY: {1: ("Wait for", "s")},
    Command.CONDITION_DISTANCE: {1: ("Until within", "m")},
    Command.CONDITION_YAW: {
        1: ("Heading", "°"), 2: ("Turn at", "°/s"), 3: ("Direction, 1 or -1", ""), 4: ("Relative", "0 or 1")
    },
    Command.DO_JUMP: {1: ("To item", ""), 2: ("Repeats", "-1: for ever")},
    Command.JUMP_TAG: {1: ("Tag", "")},
    Command.DO_JUMP_TAG: {1: ("To tag", ""), 2: ("Repeats", "-1: for ever")},
    Command.DO_CHANGE_SPEED: {1: ("Kind, 1: over ground", ""), 2: ("Speed", "m/s"), 3: ("Throttle", "%, -1: as it is")},
    Command.DO_SET_SERVO: {1: ("Servo", ""), 2: ("Pulse", "µs")},
    Command.DO_SET_RELAY: {1: ("Relay", ""), 2: ("On", "0 or 1")},
    Command.DO_SET_ROI_LOCATION: {},
    Command.DO_MOUNT_CONTROL: {1: ("Pitch", "°"), 2: ("Roll", "°"), 3: ("Yaw", "°")},
    Command.DO_SET_CAM_TRIGG_DIST: {1: ("A photo every", "m, 0: no more"), 3: ("First at once", "0 or 1")},
    Command.DO_SET_CAM_TRIGG_INTERVAL: {1: ("A photo every", "ms")},
    Command.IMAGE_START_CAPTURE: {2: ("A photo every", "s"), 3: ("Photos", "0: no end")},
    Command.IMAGE_STOP_CAPTURE: {},
    Command.DO_GRIPPER: {1: ("Gripper", ""), 2: ("Hold", "0: let go, 1")},
}  # fmt: skip


def kinds_of(firmware: Firmware) -> tuple[ItemKind, ...]:
    """Return the firmware's mission commands, moving ones first."""
    lists = firmware.fence.keys() | firmware.rally.keys()
    taken = sorted((firmware.placed.keys() | firmware.plain.keys()) - lists)
    return tuple(kind_of(command, command in firmware.placed) for command in taken)


def kind_of(command: int, placed: bool) -> ItemKind:
    name = "take off" if command == Command.NAV_TAKEOFF else short_name(command)
    return ItemKind(command=command, name=name, placed=placed, fields=tuple(_fields(command, placed)))


def _fields(command: int, placed: bool) -> Iterator[ItemField]:
    ours, theirs = OURS.get(command), params_in_words(command)
    for number in range(1, 5 if placed else 8):
        label, unit = (ours or {}).get(number, ("", ""))
        if not label and ours is not None:
            continue
        if label or number in theirs:
            about = theirs.get(number, "")
            what = f"param{number}"
            yield ItemField.model_validate(
                {"what": what, "label": label or _shortened(about), "unit": unit, "about": about}
            )


def _shortened(words: str) -> str:
    first = re.split(r"[.,;:(]", words, maxsplit=1)[0].strip() or words
    if len(first) <= LONGEST:
        return first
    return first[:LONGEST].rsplit(" ", 1)[0] + " …"


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
