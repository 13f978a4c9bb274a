from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np
import shapely

from ipoa_mission import Forecast
from ipoa_mission.report.panels.ground_plan import MapLayers, line_path, ring_path
from ipoa_mission.report.panels.tables import plain_table
from ipoa_mission.report.summary import clearance_as_json, findings_as_json, items_as_json, rounded
from ipoa_mission.survey.survey_plan import SurveyPlan, coverage_lines, flight_table


def survey_as_json(plan: SurveyPlan, names: tuple[str, ...]) -> dict[str, Any]:
    seen = plan.coverage
    sight = plan.sight
    flown = plan.flown
    return {
        "lines": len(plan.tour.swaths),
        "covered_share": rounded(seen.share),
        "seen_m2": rounded(seen.seen.area),
        "outside_m": rounded(seen.outside_m),
        "as_flown": flown and {"covered_share": rounded(flown.share), "outside_m": rounded(flown.outside_m)},
        "photos": plan.photos,
        "line_spacing_m": rounded(sight.spacing),
        "trigger_distance_m": None if sight.trigger is None else rounded(sight.trigger),
        "height_above_ground_m": [rounded(sight.least), rounded(sight.least + sight.band)],
        "overlap": _overlap_as_json(plan),
        "speed_m_s": rounded(plan.scenario.vehicle.cruise_speed),
        "flights": [
            {
                "file": f"{name}.plan",
                "lines": len(flight.tour.swaths),
                "photos": sight.photos_of(flight.tour),
                "time_s": rounded(flight.forecast.estimate.total_s),
                "energy_wh": None if flight.forecast.energy is None else rounded(flight.forecast.energy.energy_wh),
                "clearance": clearance_as_json(flight.forecast.guarantee),
                **({"findings": findings_as_json(flight.findings)} if flight.findings else {}),
            }
            for name, flight in zip(names, plan.flights, strict=True)
        ],
    }


def _overlap_as_json(plan: SurveyPlan) -> dict[str, Any] | None:
    if plan.overlaps is None:
        return None
    least = {"front": plan.overlaps.front, "side": plan.overlaps.side}
    return {
        direction: overlap
        and {"least": rounded(overlap.share), "asked": rounded(requested), "at": [rounded(x) for x in overlap.at]}
        for (direction, overlap), requested in zip(least.items(), plan.sight.overlaps, strict=True)
    }


def forecast_as_json(forecast: Forecast) -> dict[str, Any]:
    mission = forecast.mission
    return {
        "firmware": mission.autopilot.facts(mission.firmware_version),
        "clearance": clearance_as_json(forecast.guarantee),
        **items_as_json(forecast),
        "energy_wh": None if forecast.energy is None else rounded(forecast.energy.energy_wh),
        **({"parameters": dict(mission.parameters)} if mission.parameters else {}),
    }


def survey_panel(plan: SurveyPlan, names: Sequence[str]) -> str:
    words = ". ".join(coverage_lines(plan))
    note = f"{words[:1].upper()}{words[1:]}. Map: covered ground is shaded, gaps are red, a color is a flight."
    marks = [f'<span aria-hidden="true" style="color:{_hue(n)}">━</span> ' for n in range(len(names))]
    table = plain_table(*flight_table(plan, names), marks)
    return f'<section><h2>Survey</h2><p class="note">{escape(note)}</p>{table}</section>'


def survey_layers(plan: SurveyPlan) -> MapLayers:
    """Draw the area, the parts kept out, seen and missed, and the lines of each flight."""
    shaded = "fill:currentColor;fill-opacity:.1;fill-rule:evenodd"
    around = plan.area.shape.buffer(plan.sight.spacing)
    outside = shapely.Polygon() if plan.keep_out is None else plan.keep_out.intersection(around)
    layers = [
        f'<path style="{shaded};stroke:currentColor" d="{_rings(plan.area.shape)}"/>',
        f'<path class="zone" style="fill:none" d="{_rings(outside)}"/>',
        f'<path style="{shaded}" d="{_rings(plan.coverage.seen.simplify(0.1))}"/>',  # [m]
    ]
    for n, flight in enumerate(plan.flights):
        lines = "".join(line_path(swath.ends) for swath in flight.tour.swaths)
        transits = "".join(map(line_path, flight.tour.transits))
        layers.append(f'<path style="fill:none;stroke:{_hue(n)}" d="{lines}"/>')
        layers.append(f'<path style="fill:none;stroke:{_hue(n)};stroke-dasharray:4 3" d="{transits}"/>')
    layers.append(f'<path style="fill:var(--bad)" d="{_rings(plan.coverage.gaps)}"/>')
    return MapLayers("".join(layers), np.reshape(around.bounds, (2, 2)))


def _hue(flight: int) -> str:
    hues = (210, 35, 285, 150, 325, 75)  # far apart and far from the red of gaps [deg]
    return f"hsl({hues[flight % len(hues)]} 65% {48 if flight // len(hues) % 2 == 0 else 30}%)"


def _rings(shape: Any) -> str:
    polygons = [part for part in shapely.get_parts(shape) if part.geom_type == "Polygon" and not part.is_empty]
    return "".join(ring_path(shapely.get_coordinates(ring)) for ring in shapely.get_rings(polygons))
