"""One HTML file that contains everything and prints."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from importlib.metadata import version
from importlib.resources import files
from string import Template
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.finding import Finding
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.mission.flight_record import FlightRecord
from ipoa_mission.mission.item_words import count_words
from ipoa_mission.mission.items import Mission
from ipoa_mission.planning.planner import Plan
from ipoa_mission.report import drawn_flight
from ipoa_mission.report.compare import compare_flight, flown_track
from ipoa_mission.report.drawn_flight import DrawnFlight, ItemLeg, SampledTrack, item_legs, sample_track
from ipoa_mission.report.panels.contingency_panel import contingency_strip, return_paths
from ipoa_mission.report.panels.ground_plan import NO_LAYERS, MapLayers, ground_plan, legend
from ipoa_mission.report.panels.headline import figures, verdict, warnings
from ipoa_mission.report.panels.profile import distance_profile, height_profile, profile_legend, speed_profile
from ipoa_mission.report.panels.tables import legs_table, limits_table
from ipoa_mission.scenario import Scenario


@dataclass(frozen=True)
class PageNotes:
    """`findings`: of the check; `panel`: of a survey or flight parts; `layers`: of a survey."""

    findings: Sequence[Finding]
    remarks: Sequence[str] = ()
    panel: str = ""
    layers: MapLayers = NO_LAYERS


def report_html(
    forecast: Forecast, notes: PageNotes, plan: Plan | None = None, flight: FlightRecord | None = None
) -> str:
    scenario = forecast.world
    mission = forecast.mission
    proof = forecast.proof_if_known
    airspace = scenario.airspace
    required = scenario.limits.obstacle_distance

    legs = item_legs(forecast)
    predicted = sample_track(forecast.estimate.track, airspace)
    track = None if flight is None else flown_track(forecast, flight)
    flown = None if track is None else sample_track(track, airspace)
    comparison = None if flight is None else compare_flight(forecast.estimate, flight)
    drawn = DrawnFlight(scenario, predicted, legs, flown, drawn_flight.shown_deviation_bound(forecast))
    places = np.array([leg.place for leg in legs if leg.place is not None]).reshape(-1, 3)
    tracks = [track.points for track in (predicted, flown) if track is not None]
    extent = drawn_flight.extent_of(*(points[:, :2] for points in (places, *tracks, notes.layers.around)))
    has_zones = extent.obstacles(airspace) != extent.buildings(airspace)
    dangers = drawn_flight.find_dangers(predicted, scenario)
    returns = return_paths(forecast)
    waypoints = sum(leg.item.is_waypoint for leg in legs)
    vehicle = f"Mission for {mission.autopilot.firmware().name}, {count_words(len(mission.items))}"
    parts = {
        "title": escape(scenario.name),
        "subtitle": escape(f"{vehicle}, cruise {scenario.vehicle.cruise_speed:g} m/s"),
        "verdict": verdict(proof, forecast.guarantee_if_known, dangers, notes.findings),
        "figures": figures(forecast, float(predicted.along[-1]), waypoints, comparison),
        "warnings": warnings(dangers, notes.findings, [*notes.remarks, *forecast.estimate.remarks], scenario.remarks),
        "survey": notes.panel,
        "map": ground_plan(drawn, extent, notes.layers),
        "legend": legend(scenario, extent, flown is not None, bool(returns)),
        "profile": height_profile(drawn),
        "apart": distance_profile(predicted, required),
        "profile_note": f"The pale band is the {required:g} m round the path that must stay free.",
        "profile_legend": profile_legend(flown is not None, has_zones),
        "contingencies": contingency_strip(forecast, predicted),
        "speed": speed_profile(drawn),
        "legs": legs_table(legs, None if flight is None else flight.timed_items_s),
        "limits": "" if proof is None else limits_table(proof),
        "footer": _footer(scenario, plan, mission),
        "map_js": _asset("map.js"),
        "page_js": _asset("page.js"),
        "data": _page_data(predicted, legs, returns),
    }
    return _page_of(parts)


def _page_data(predicted: SampledTrack, legs: Sequence[ItemLeg], returns: Sequence[Mapping[str, Any]]) -> str:
    """Return the flight as JSON, safe inside an HTML script."""
    decimals = {"times": 2, "along": 1, "points": 2, "speeds": 2, "ground": 2, "apart": 2}
    data = {
        "course": {name: _rounded(getattr(predicted, name), digits) for name, digits in decimals.items()},
        "stops": [
            {
                "seq": leg.time.seq,
                "name": leg.name,
                "reason": leg.time.reason,
                "index": predicted.nearest(leg.time.done_s),
                "place": None if leg.place is None else _rounded(leg.place[:2], 2),
            }
            for leg in legs
        ],
        "home": [*returns],
    }
    return json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def _rounded(values: NDArray[np.float64], digits: int) -> list[Any]:
    if values.ndim > 1:
        return [_rounded(row, digits) for row in values]
    return [round(float(v), digits) if math.isfinite(v) else None for v in values]


def _footer(scenario: Scenario, plan: Plan | None, mission: Mission) -> str:
    home = mission.home
    parameters = ", ".join(f"{name} {value:g}" for name, value in mission.parameters.items())
    rows = {
        "home": f"{home.latitude_deg:.7f}, {home.longitude_deg:.7f}, {home.altitude:g} m above mean sea level",
        "vehicle": f"radius {scenario.vehicle.radius:g} m, safety distance {scenario.safety_distance:g} m",
        "parameters": parameters or "the autopilot's defaults",
        "world": f"{len(scenario.airspace.obstacles)} obstacles, {scenario.terrain.kind} terrain",
        **({"planned by": f"{plan.optimizer}, seed {plan.seed}"} if plan is not None else {}),
        "made by": f"ipoa-mission {version('ipoa-mission')}",
    }
    body = "".join(f"<dt>{name}</dt><dd>{escape(words)}</dd>" for name, words in rows.items())
    return f"<dl>{body}</dl>"


def _page_of(parts: Mapping[str, str]) -> str:
    controls = dict.fromkeys((*range(9), 11, 12, *range(14, 32), *range(127, 160)), "\N{REPLACEMENT CHARACTER}")
    css = "".join(map(_asset, ("palette.css", "page.css", "ways.css")))
    head = Template(_asset("head.html")).substitute(parts, css=css)
    return Template(_asset("page.html")).substitute(parts, head=head).translate(controls)


def _asset(name: str) -> str:
    return files("ipoa_mission.report").joinpath("assets", name).read_text(encoding="utf-8")
