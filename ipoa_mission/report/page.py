"""One HTML file that contains everything and prints."""

import json
import math
from collections.abc import Mapping, Sequence
from html import escape
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.autopilot.commands import WAYPOINTS
from ipoa_mission.checks.check import check
from ipoa_mission.files import write_atomically
from ipoa_mission.finding import Finding
from ipoa_mission.forecast.contingency.energy_budget import budget_of
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.link.logbook import FlightRecord
from ipoa_mission.mission.items import Mission
from ipoa_mission.planning.plan import Plan
from ipoa_mission.report.chart import extent_of
from ipoa_mission.report.compare import compare_flight, flown_track
from ipoa_mission.report.panels.contingency_panel import contingency_strip
from ipoa_mission.report.panels.flown_panel import done_in_flight, flown_panel
from ipoa_mission.report.panels.ground_plan import ground_plan, legend
from ipoa_mission.report.panels.headline import figures, verdict, warnings
from ipoa_mission.report.panels.legs_panel import legs
from ipoa_mission.report.panels.planned_panel import limits_table, search_panel
from ipoa_mission.report.panels.profile import distance_profile, height_profile, profile_legend, speed_profile
from ipoa_mission.report.seen import Seen, dangers, deviation_bound_seen, follow
from ipoa_mission.report.stops import FlownItem, stops
from ipoa_mission.report.ways_home import ways_home
from ipoa_mission.scenario import Scenario

#: A page may not contain these.
_CONTROLS = dict.fromkeys((*range(9), 11, 12, *range(14, 32), *range(127, 160)), "\N{REPLACEMENT CHARACTER}")


def write_report(
    forecast: Forecast,
    path: str | Path,
    plan: Plan | None = None,
    flight: FlightRecord | None = None,
    remarks: Sequence[str] = (),
) -> None:
    """Write the report on a mission, one page without a server.

    Args:
        forecast: of the mission, in the world of a scenario.
        path: of an HTML file.
        plan: of the mission, if known.
        flight: as flown, if it was.
        remarks: shown first, with the estimate's own.

    Raises:
        BadInput: the folder may not be written.

    Example:
        >>> from ipoa_mission import Forecast, read_mission, read_scenario, write_report
        >>> forecast = Forecast(read_mission("missions/sitl.plan"), read_scenario("missions/sitl.toml"))
        >>> write_report(forecast, "sitl.html")
    """
    write_atomically(Path(path), report_html(forecast, plan, flight, remarks))


def report_html(
    forecast: Forecast,
    plan: Plan | None = None,
    flight: FlightRecord | None = None,
    remarks: Sequence[str] = (),
    findings: Sequence[Finding] | None = None,
    survey: str = "",
) -> str:
    """`findings` saves a second check; `survey` is a panel of its survey or parts."""
    findings = check(forecast) if findings is None else findings
    scenario, mission, estimate, promise = (
        forecast.world,
        forecast.mission,
        forecast.estimate,
        forecast.promise_if_known,
    )
    proof = forecast.proof_if_known
    airspace, required = scenario.airspace, scenario.limits.obstacle_distance
    stop_list = stops(forecast)
    course = follow(estimate.track, airspace)
    track = None if flight is None else flown_track(mission, flight)
    flown = None if track is None else follow(track, airspace)
    places = np.array([stop.place for stop in stop_list if stop.place is not None]).reshape(-1, 3)
    danger = dangers(course, scenario)
    extent = extent_of(places, course.points, *([] if flown is None else [flown.points]))
    comparison = None if flight is None else compare_flight(estimate, flight)
    deviation_bound = deviation_bound_seen(forecast)
    home = ways_home(forecast)
    parts = {
        "title": escape(scenario.name),
        "subtitle": escape(_subtitle(scenario, mission)),
        "verdict": verdict(proof, promise, danger, findings),
        "figures": figures(
            estimate,
            promise,
            float(course.along[-1]),
            sum(stop.item.command in WAYPOINTS for stop in stop_list),
            comparison,
            budget_of(forecast),
        ),
        "warnings": warnings(danger, findings, [*remarks, *estimate.remarks], scenario.remarks),
        "survey": survey,
        "map": ground_plan(scenario, extent, stop_list, course, flown, deviation_bound),
        "legend": legend(scenario, extent, flown is not None, bool(home)),
        "profile": height_profile(course, airspace, required, stop_list, flown, deviation_bound),
        "apart": distance_profile(course, required),
        "profile_note": f"The pale band is the {required:g} m round the path that must stay free.",
        "profile_legend": profile_legend(flown is not None, extent.obstacles(airspace) != extent.buildings(airspace)),
        "endings": contingency_strip(forecast, course),
        "speed": speed_profile(course, stop_list, flown),
        "speed_note": "As predicted; a tick where an item is done.",
        "flight": "" if comparison is None else flown_panel(comparison),
        "legs": legs(stop_list, None if flight is None else done_in_flight(stop_list, flight.item_reached_s)),
        "legs_note": LEGS_NOTE,
        "limits": "" if proof is None else limits_table(proof),
        "search": "" if plan is None else search_panel(plan, scenario),
        "footer": _footer(scenario, plan, mission),
        "map_js": _asset("map.js"),
        "page_js": _asset("page.js"),
        "data": _page_data(course, stop_list, home),
    }
    return page_of("page.html", parts)


def _page_data(course: Seen, stops: Sequence[FlownItem], home: Sequence[Mapping[str, Any]]) -> str:
    """Return the flight as JSON that is safe inside an HTML script element."""
    data = {
        "course": {
            "times": _rounded(course.times, 2),
            "along": _rounded(course.along, 1),
            "points": _rounded(course.points, 2),
            "speeds": _rounded(course.speeds, 2),
            "ground": _rounded(course.ground, 2),
            "apart": _rounded(course.apart, 2),
        },
        "stops": [_stop_data(stop, course) for stop in stops],
        "home": [*home],
    }
    return json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def _stop_data(stop: FlownItem, course: Seen) -> dict[str, Any]:
    place = None if stop.place is None else _rounded(stop.place[:2], 2)
    index = course.nearest(stop.time.done_s)
    return {"seq": stop.time.seq, "name": stop.name, "reason": stop.time.reason, "index": index, "place": place}


def _rounded(values: NDArray[np.float64], digits: int) -> list[Any]:
    if values.ndim > 1:
        return [_rounded(row, digits) for row in values]
    return [round(float(v), digits) if math.isfinite(v) else None for v in values]


LEGS_NOTE = (
    "Heights are above home, times from arming; clearance is the least distance of the leg "
    "to the ground or an obstacle."
)


def _subtitle(scenario: Scenario, mission: Mission) -> str:
    words = f"Mission for {mission.autopilot.firmware().name}, {len(mission.items)} items"
    return f"{words}, cruise {scenario.vehicle.cruise_speed:g} m/s"


def _footer(scenario: Scenario, plan: Plan | None, mission: Mission) -> str:
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


def page_of(template: str, parts: Mapping[str, str]) -> str:
    """Remove control characters; `title` is a part."""
    css = "".join(map(_asset, ("palette.css", "page.css", "ways.css")))
    head = Template(_asset("head.html")).substitute(parts, css=css)
    return Template(_asset(template)).substitute(parts, head=head).translate(_CONTROLS)


def _asset(name: str) -> str:
    return files("ipoa_mission.report").joinpath("assets", name).read_text(encoding="utf-8")
