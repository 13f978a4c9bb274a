"""The report: one HTML file that holds everything, opens anywhere without a network, and prints.

All is drawn here as HTML and SVG; the script on the page links the views and turns the 3D one.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from string import Template

import numpy as np

from ipoa_mission.checks.check import check_mission
from ipoa_mission.checks.clearance import promise_if_known
from ipoa_mission.commands import WAYPOINTS
from ipoa_mission.energy.flight import Consumption
from ipoa_mission.files import write_atomically
from ipoa_mission.finding import Finding
from ipoa_mission.items import Mission
from ipoa_mission.link.logbook import FlightRecord
from ipoa_mission.planning.plan import Plan
from ipoa_mission.planning.proof import Proof
from ipoa_mission.report.compare import compare_flight, flown_track
from ipoa_mission.report.course import dangers, follow, tube_of
from ipoa_mission.report.extent import extent_of
from ipoa_mission.report.panels.flown import done_in_flight, flown_panel
from ipoa_mission.report.panels.ground_plan import ground_plan, legend
from ipoa_mission.report.panels.headline import figures, verdict, warnings
from ipoa_mission.report.panels.legs import legs
from ipoa_mission.report.panels.planned import limits_table, search_panel
from ipoa_mission.report.panels.profile import distance_profile, height_profile, profile_legend, speed_profile
from ipoa_mission.report.scene import page_data
from ipoa_mission.report.stops import stops
from ipoa_mission.routing.prove_route import cruise, prove_mission
from ipoa_mission.scenario import Scenario
from ipoa_mission.scenario.budget import flight_energy
from ipoa_mission.timing.estimate import Estimate
from ipoa_mission.tube.promise import Promise


@dataclass(frozen=True)
class Subject:
    """What a page is made from; `plan` is None where nobody knows how the mission was planned."""

    scenario: Scenario
    plan: Plan | None
    mission: Mission
    estimate: Estimate
    remarks: Sequence[str]
    proof: Proof | None
    promise: Promise | None
    energy: Consumption | None
    findings: Sequence[Finding] = ()


def write_report(
    path: str | Path,
    scenario: Scenario,
    plan: Plan | None,
    mission: Mission,
    estimate: Estimate,
    flight: FlightRecord | None = None,
    remarks: Sequence[str] = (),
) -> None:
    """Write the report on a mission to `path`: on how it was planned if `plan` is there, and flown if `flight` is.

    `remarks` (what a check found, say) are shown first, with the estimate's own.

    Raises:
        BadInput: the folder may not be written.
    """
    write_atomically(Path(path), report_html(scenario, plan, mission, estimate, flight, remarks))


def report_html(
    scenario: Scenario,
    plan: Plan | None,
    mission: Mission,
    estimate: Estimate,
    flight: FlightRecord | None = None,
    remarks: Sequence[str] = (),
) -> str:
    """The whole page."""
    proof = prove_mission(mission, scenario) if cruise(mission, scenario) else None
    promise = promise_if_known(mission, scenario)
    energy = flight_energy(scenario, estimate.track.times, estimate.track.points, estimate.track.speeds)
    findings = check_mission(mission, scenario, promise)
    return page_html(Subject(scenario, plan, mission, estimate, remarks, proof, promise, energy, findings), flight)


def page_html(subject: Subject, flight: FlightRecord | None = None) -> str:
    """The same, of what was proved already."""
    scenario, mission, estimate, proof = subject.scenario, subject.mission, subject.estimate, subject.proof
    airspace, required = scenario.airspace, scenario.limits.obstacle_distance
    stop_list = stops(mission, estimate, scenario)
    course = follow(estimate.track, airspace)
    track = None if flight is None else flown_track(mission, flight)
    flown = None if track is None else follow(track, airspace)
    places = np.array([stop.place for stop in stop_list if stop.place is not None])
    danger = dangers(course, scenario)
    extent = extent_of(places, course.points, *([] if flown is None else [flown.points]))
    comparison = None if flight is None else compare_flight(estimate, flight)
    tube = tube_of(mission, scenario)
    battery = scenario.vehicle.battery
    parts = {
        "title": escape(scenario.name),
        "subtitle": escape(_subtitle(scenario, mission)),
        "verdict": verdict(proof, subject.promise, danger, subject.findings),
        "figures": figures(
            estimate,
            subject.promise,
            float(course.along[-1]),
            sum(stop.item.command in WAYPOINTS for stop in stop_list),
            comparison,
            subject.energy,
            battery,
        ),
        "warnings": warnings(danger, subject.findings, [*subject.remarks, *estimate.remarks]),
        "map": ground_plan(scenario, extent, stop_list, course, flown, tube),
        "legend": legend(scenario, extent, flown is not None),
        "profile": height_profile(course, airspace, required, stop_list, flown, tube),
        "apart": distance_profile(course, required),
        "profile_note": f"The pale band is the {required:g} m round the path that must stay free.",
        "profile_legend": profile_legend(flown is not None, extent.obstacles(airspace) != extent.buildings(airspace)),
        "speed": speed_profile(course, stop_list, flown),
        "speed_note": "As predicted; a tick where an item is done.",
        "flight": "" if comparison is None else flown_panel(comparison),
        "legs": legs(stop_list, None if flight is None else done_in_flight(stop_list, flight.item_reached_s)),
        "legs_note": LEGS_NOTE,
        "limits": "" if proof is None else limits_table(proof),
        "search": "" if subject.plan is None else search_panel(subject.plan, scenario),
        "footer": _footer(scenario, subject.plan, mission),
        "css": _asset("palette.css") + _asset("page.css"),
        "map_js": _asset("map.js"),
        "scene_js": _asset("scene.js"),
        "page_js": _asset("page.js"),
        "data": page_data(scenario, extent, course, stop_list, flown, tube),
    }
    return Template(_asset("page.html")).substitute(parts)


LEGS_NOTE = (
    "Heights are above home, times from arming; clearance is the least distance of the leg "
    "to the ground or an obstacle."
)


def _subtitle(scenario: Scenario, mission: Mission) -> str:
    words = f"Mission for {mission.autopilot.firmware().name}, {len(mission.items)} items"
    return f"{words}, cruise {scenario.vehicle.cruise_speed:g} m/s"


def _footer(scenario: Scenario, plan: Plan | None, mission: Mission) -> str:
    """What the report was made from, so that it can be made again."""
    home, changed = mission.home, mission.parameters
    rows = {
        "home": f"{home.latitude_deg:.7f}, {home.longitude_deg:.7f}, {home.altitude:g} m above mean sea level",
        "vehicle": f"radius {scenario.vehicle.radius:g} m, safety distance {scenario.safety_distance:g} m",
        "parameters": ", ".join(f"{name} {value:g}" for name, value in changed.items()) or "the autopilot's defaults",
        "world": f"{len(scenario.airspace.obstacles)} obstacles, {scenario.terrain.kind} terrain",
        **({"planned by": f"{plan.optimizer}, seed {plan.seed}"} if plan is not None else {}),
        "made by": f"ipoa-mission {version('ipoa-mission')}",
    }
    body = "".join(f"<dt>{name}</dt><dd>{escape(words)}</dd>" for name, words in rows.items())
    return f"<dl>{body}</dl>"


def _asset(name: str) -> str:
    return files("ipoa_mission.report").joinpath("assets", name).read_text(encoding="utf-8")
