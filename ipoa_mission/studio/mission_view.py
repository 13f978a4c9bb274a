"""An open mission on the page, and its findings."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ipoa_mission import Finding, Forecast, Item, Mission, MissionError, MissionFile
from ipoa_mission.autopilot.autopilot import registered
from ipoa_mission.autopilot.commands import Command, short_name
from ipoa_mission.checks.firmware_check import is_too_long
from ipoa_mission.forecast.itinerary.flown_legs import item_places
from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.link.definitions import labeled_params
from ipoa_mission.mission import stored_mission
from ipoa_mission.mission.item_edits import complex_at
from ipoa_mission.mission.item_words import item_words
from ipoa_mission.mission.positions import refusals
from ipoa_mission.scenario.place_sections import FenceSection
from ipoa_mission.studio import answers
from ipoa_mission.studio.dropped import fences_of
from ipoa_mission.studio.flight_answers import Checked, ItemKind, MissionItem, OpenMission
from ipoa_mission.studio.plan_answers import UNKNOWN_EXTENT
from ipoa_mission.studio.view import corners_of, degree_of, fence_of, without_folders, world_of
from ipoa_mission.terminal import round_finite


def kind_of(command: int, placed: bool) -> ItemKind:
    """Return a command with the params that MAVLink labels; a placed item's position has none."""
    fields = [
        {"what": f"param{number}", "label": label, "unit": unit.replace("deg", "°"), "about": about}
        for number, (label, unit, about) in labeled_params(command).items()
        if number < (5 if placed else 8)
    ]
    name = "take off" if command == Command.NAV_TAKEOFF else short_name(command)
    return ItemKind.model_validate({"command": command, "name": name, "fields": fields})


def mission_answer(file: MissionFile, forecast: Forecast, worlds: Sequence[str], world: str | None) -> OpenMission:
    mission = forecast.mission_as_read
    firmware = mission.firmware
    commands = (firmware.placed.keys() | firmware.plain.keys()) - firmware.fence.keys() - firmware.rally.keys()
    kinds = {command: kind_of(command, command in firmware.placed) for command in sorted(commands)}
    for item in mission.items:
        kinds.setdefault(item.command, kind_of(item.command, item.has_position))
    parts = complex_at(mission)
    return OpenMission(
        autopilot=str(mission.autopilot),
        autopilots=tuple(map(str, registered())),
        firmware=mission.autopilot.checked_for(mission.firmware_version),
        scenario=world,
        worlds=tuple(worlds),
        items=tuple(_item(seq, item, mission, parts[seq - 1]) for seq, item in enumerate(mission.items, start=1)),
        kinds=tuple(kinds.values()),
        lost=tuple(finding.message for finding in file.findings),
    )


def _item(seq: int, item: Item, mission: Mission, part: range | None) -> MissionItem:
    placed = item.command in mission.firmware.placed
    on_it = placed and (item.latitude_deg, item.longitude_deg) != (0.0, 0.0)
    return MissionItem(
        seq=seq,
        command=item.command,
        words=item_words(item),
        frame=item.frame,
        values=tuple(round_finite(value, 9) for value in stored_mission.values_of(item)),
        place=(round(item.longitude_deg, 7), round(item.latitude_deg, 7)) if on_it else None,
        up=round_finite(mission.altitude_above_home(item), 9) if placed else None,
        part_of=None if part is None else (part.start, part.stop - 1),
    )


def mission_world(forecast: Forecast) -> answers.World:
    mission = forecast.mission_as_read
    scenario = forecast.scenario
    frame = LocalFrame(mission.home)
    home = (round(mission.home.longitude_deg, 7), round(mission.home.latitude_deg, 7))
    spot = answers.Spot(name="home", path=("home",), place=home, up=0.0, above_ground=0.0)
    sections = map(FenceSection.model_validate, fences_of(mission))
    fences = tuple(fence_of(n, section, frame) for n, section in enumerate(sections))
    if scenario is not None and scenario.why_elsewhere(mission.home) is None:
        world = world_of(scenario)
        bodies = tuple(body.model_copy(update={"path": None}) for body in world.bodies)
        spot = spot.model_copy(update={"up": round(float(forecast.home[2]), 2)})
        return world.model_copy(update={"spots": (spot,), "bodies": bodies, "fences": fences})
    places = [place[:2] for place in item_places(mission, frame, forecast.ground) if place is not None]
    points = np.array([np.zeros(2), *places])
    points = points[np.isfinite(points).all(axis=1) & (np.abs(points) < UNKNOWN_EXTENT / 10).all(axis=1)]
    room = max(60.0, 0.25 * float(np.ptp(points, axis=0).max()))  # [m]
    corners = corners_of(frame, points.min(axis=0) - room, points.max(axis=0) + room)
    return answers.World(
        box=(*corners[0], *corners[2]),
        around=corners,
        degree_m=degree_of(frame),
        spots=(spot,),
        fences=fences,
        heights=answers.Heights(corner=corners[0], step=(1.0, 1.0), columns=1, up=()),
        home_amsl=mission.home.altitude,
    )


def check_answer(findings: Sequence[Finding], forecast: Forecast) -> Checked:
    def shown(words: str) -> str:
        return words if forecast.scenario is None else without_folders(words, forecast.scenario)

    flaws = tuple(
        replace(finding, message=shown(finding.message), hint=finding.hint and shown(finding.hint), remedies=())
        for finding in findings
    )
    remarks = () if forecast.scenario is None else tuple(map(shown, forecast.scenario.remarks))
    return Checked(flaws=flaws, timeless=_why_timeless(forecast), remarks=remarks)


def _why_timeless(forecast: Forecast) -> str | None:
    mission = forecast.mission_as_read
    scenario = forecast.scenario
    if not mission.items:
        return "it has no item"
    if refusals(mission):
        return "a position or a height is not valid"
    if is_too_long(mission):
        return "its vehicle holds fewer items"
    if scenario is not None and scenario.why_elsewhere(mission.home) is not None:
        return "it is at another place than the scenario"
    try:
        return None if len(forecast.estimate.track.times) > 1 else "nothing in it moves the vehicle"
    except MissionError as error:
        return str(error)
