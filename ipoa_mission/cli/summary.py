"""What a planned mission is like: in a few lines for a human, and as NAME.json for machines."""

import math
from dataclasses import asdict
from importlib.metadata import version
from typing import Any

from ipoa_mission.cli.checking import route_as_json, route_in_words
from ipoa_mission.cli.job import PlannedJob
from ipoa_mission.maps.passed import count_passed_over
from ipoa_mission.mission.assemble import Option
from ipoa_mission.mission.prove_route import prove_mission
from ipoa_mission.planning.proof import Proof
from ipoa_mission.scenario import Scenario


def describe(job: PlannedJob) -> list[str]:
    """The plan in a few lines."""
    least = prove_mission(job.mission, job.scenario).clearance
    required = job.scenario.vehicle.radius + job.scenario.safety_distance
    lines = [
        f"{job.name}: {job.plan.cost.length:.1f} m, {len(job.mission.items)} items, for {job.mission.autopilot}",
        f"least clearance {least.distance:.2f} m, to {least.what}; {required:.2f} m required; proved, leg by leg",
        f"estimated {job.estimate.total_s:.1f} s; QGroundControl would say {job.estimate.qgroundcontrol_s:.0f} s",
        *route_in_words(job.estimate),
    ]
    if job.energy is not None:
        lines.append(f"energy {job.energy.energy_wh:.1f} Wh, {job.energy.mean_w:.0f} W on average")
    return [*lines, *(f"note: {remark}" for remark in job.remarks)]


ROUTE_COLUMNS = [
    "",
    "mode",
    "waypoints",
    "takes\ns",
    "times the\ncurve's least",
    "leaves the\ncurve by, m",
    "keeps its limits",
]


def route_rows(job: PlannedJob) -> list[tuple[str, ...]]:
    """What each way to choose waypoints would come to, quickest first; the chosen one is marked."""
    return [
        (
            "*" if option.mode == job.scenario.route.mode else " ",
            option.mode + (" (splines)" if option.route.spline and option.mode != "spline" else ""),
            str(len(option.route.points)),
            f"{option.seconds:.1f}",
            f"{option.ratio:.2f}",
            f"{option.deviation:.1f}",
            "yes" if option.flies_clear else "no: flown, it comes too close",
        )
        for option in job.options
    ]


def summarise(job: PlannedJob) -> dict[str, Any]:
    """Metres, seconds, degrees; the same plan gives the same numbers. `legs` are those that will be flown."""
    scenario, plan, mission, estimate, energy = job.scenario, job.plan, job.mission, job.estimate, job.energy
    legs = prove_mission(mission, scenario)
    return {
        "name": scenario.name,
        "version": version("ipoa-mission"),
        "seed": plan.seed,
        "optimizer": plan.optimizer,
        "evaluations": int(plan.evaluations[-1]),
        "cost": {name: _rounded(value) for name, value in asdict(plan.cost).items()},
        "clearance": {"curve": _clearance(plan.proof), "legs": _clearance(legs)},
        "limits": [
            {"limit": c.limit, "found": _rounded(c.found.distance), "required": _rounded(c.required), "unit": c.unit}
            for c in legs.checks
            if math.isfinite(c.found.distance)
        ],
        "control_points": [[_rounded(value) for value in point] for point in plan.curve.control],
        "items": len(mission.items),
        "estimate": {
            "total_s": _rounded(estimate.total_s),
            "qgroundcontrol_s": _rounded(estimate.qgroundcontrol_s),
            "route": route_as_json(estimate),
        },
        "energy_wh": None if energy is None else _rounded(energy.energy_wh),
        "remarks": list(job.remarks),
        "passed_over": passed_over_as_json(job.scenario),
        "routes": [_route(option, scenario.route.mode) for option in job.options],
    }


def passed_over_as_json(scenario: Scenario) -> list[dict[str, Any]]:
    """What the scenario's maps have that became no obstacle, counted by file and reason."""
    return [asdict(counted) for counted in count_passed_over(scenario.passed_over)]


def _route(option: Option, mode: str) -> dict[str, Any]:
    return {
        "mode": option.mode,
        "waypoints": len(option.route.points),
        "spline": option.route.spline,
        "seconds": option.seconds,
        "ratio": option.ratio,
        "deviation": option.deviation,
        "flies_clear": option.flies_clear,
        "chosen": option.mode == mode,
    }


def _clearance(proof: Proof) -> dict[str, Any]:
    least = proof.clearance
    return {"least": _rounded(least.distance), "to": least.what, "at": [_rounded(value) for value in least.place]}


def _rounded(value: float) -> float:
    return round(float(value), 6)
