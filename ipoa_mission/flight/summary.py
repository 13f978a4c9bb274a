"""NAME.json: what a planned flight is like, for machines. The same flight gives the same numbers."""

import math
from dataclasses import asdict
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from ipoa_mission.maps.passed import count_passed_over
from ipoa_mission.mission.landing_ground import KEY, landing_ground
from ipoa_mission.planning.proof import Proof
from ipoa_mission.routing.assemble import Option
from ipoa_mission.scenario import Scenario
from ipoa_mission.timing.estimate import Estimate
from ipoa_mission.tube.promise import Promise

if TYPE_CHECKING:
    from ipoa_mission.flight.flight import Flight


def summarize(flight: "Flight") -> dict[str, Any]:
    """Metres, seconds, degrees. `legs` are those that will be flown."""
    scenario, plan, mission, estimate, energy = (
        flight.scenario,
        flight.plan,
        flight.mission,
        flight.estimate,
        flight.energy,
    )
    return {
        "name": scenario.name,
        "version": version("ipoa-mission"),
        "seed": plan.seed,
        "optimizer": plan.optimizer,
        "evaluations": int(plan.evaluations[-1]),
        "cost": {name: _rounded(value) for name, value in asdict(plan.cost).items()},
        "clearance": clearance_as_json(flight.promise)
        | {"curve": _clearance(plan.proof), "legs": _clearance(flight.proof)},
        "limits": [
            {"limit": c.limit, "found": _rounded(c.nearest.distance), "required": _rounded(c.required), "unit": c.unit}
            for c in flight.proof.checks
            if math.isfinite(c.nearest.distance)
        ],
        "control_points": [[_rounded(value) for value in point] for point in plan.curve.control],
        "items": len(mission.items),
        **({} if (ground := landing_ground(mission)) is None else {KEY: ground}),
        "estimate": {
            "total_s": _rounded(estimate.total_s),
            "qgroundcontrol_s": _rounded(estimate.qgroundcontrol_s),
            "route": route_summary(estimate),
        },
        "energy_wh": None if energy is None else _rounded(energy.energy_wh),
        **({"parameters": dict(mission.parameters)} if mission.parameters else {}),
        "remarks": list(flight.remarks),
        "passed_over": passed_over_as_json(scenario),
        "routes": [_route(option, scenario.route.mode) for option in flight.options],
    }


def clearance_as_json(promise: Promise | None) -> dict[str, Any]:
    """The least clearance that the flights keep, and to what on the way to which item; empty if nobody knows."""
    kept = None if promise is None else promise.clearance
    if promise is None or kept is None:
        return {}
    return {
        "required_m": round(kept.required, 3),
        "nominal_m": round(kept.nominal, 3),
        "kept_m": round(kept.kept, 3),
        "confidence": "nominal" if promise.confidence is None else round(promise.confidence, 4),
        "to": kept.to,
        "item": kept.item,
    }


def passed_over_as_json(scenario: Scenario) -> list[dict[str, Any]]:
    """What the scenario's maps have that became no obstacle, counted by file and reason."""
    return [asdict(counted) for counted in count_passed_over(scenario.passed_over)]


def route_summary(estimate: Estimate) -> dict[str, float] | None:
    """The time of the route, the least time on it, and how many times that it takes; None where there is no route."""
    route = estimate.route
    if not route.seconds > 0:
        return None
    return {"seconds": round(route.seconds, 3), "least": round(route.least, 3), "ratio": round(route.ratio, 4)}


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
