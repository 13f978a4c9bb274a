"""The content of NAME.json: clearances, limits, energies, routes and findings, rounded."""

import math
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from ipoa_mission.centimeters import ceil_cm, floor_cm
from ipoa_mission.mission.landing_ground import landing_height
from ipoa_mission.mission.mission_io import LANDING_GROUND_KEY

if TYPE_CHECKING:  # not for `check` and `estimate`
    from collections.abc import Iterable

    from ipoa_mission.autopilot.energy import Interval
    from ipoa_mission.finding import Finding
    from ipoa_mission.forecast.contingency.energy_budget import Budget
    from ipoa_mission.forecast.deviation.clearance_guarantee import ClearanceGuarantee, KeptLimit
    from ipoa_mission.forecast.forecast import Forecast
    from ipoa_mission.forecast.timing.estimate import Estimate
    from ipoa_mission.planning.proof import Proof
    from ipoa_mission.scenario import Scenario


def clearance_as_json(guarantee: "ClearanceGuarantee | None") -> dict[str, Any]:
    """Return the smallest guaranteed clearance, and shortfalls at take-off, ending and given places."""
    if guarantee is None:
        return {}
    clearance = guarantee.clearance
    confidence = "nominal" if guarantee.confidence is None else round(guarantee.confidence, 4)
    others = [{"part": other.part, "limit": other.limit} | _limit_as_json(other) for other in guarantee.elsewhere]
    elsewhere = {"elsewhere": others} if others else {}
    return elsewhere if clearance is None else _limit_as_json(clearance) | {"confidence": confidence} | elsewhere


def _limit_as_json(limit: "KeptLimit") -> dict[str, Any]:
    return {
        "required_m": ceil_cm(limit.required, 1000),
        "nominal_m": floor_cm(limit.nominal, 1000),
        "kept_m": floor_cm(limit.guaranteed, 1000),
        "to": limit.to,
        "item": limit.item,
    }


def items_as_json(forecast: "Forecast") -> dict[str, Any]:
    ground = landing_height(forecast.mission)
    estimate = forecast.estimate
    return {
        "items": len(forecast.mission.items),
        **({} if ground is None else {LANDING_GROUND_KEY: ground}),
        "estimate": {"total_s": rounded(estimate.total_s), "qgroundcontrol_s": rounded(estimate.qgroundcontrol_s)},
    }


def passed_over_as_json(scenario: "Scenario") -> list[dict[str, Any]]:
    return [asdict(counted) for counted in scenario.passed_counts]


def energy_as_json(budget: "Budget") -> dict[str, Any]:
    """Return energies (low, likely, high) [Wh] and battery shares."""
    late = budget.no_return
    return {
        "energy_wh": [rounded(wh) for wh in budget.used.between],
        "capacity_wh": None if budget.battery is None else rounded(budget.battery.capacity_wh),
        "reserve": None if budget.battery is None else rounded(budget.battery.reserve),
        "left": _shares(budget.left(budget.used.between)),
        "no_return": None if late is None else {"seq": late.seq, "time_s": rounded(late.time), "why": late.why},
        "items": [
            {"seq": item.seq, "energy_wh": [rounded(wh) for wh in item.takes], "left": _shares(item.left)}
            for item in budget.items
        ],
    }


def _shares(left: "Interval | None") -> list[float] | None:
    return None if left is None else [rounded(share) for share in left]


def route_summary(estimate: "Estimate") -> dict[str, float] | None:
    return {"seconds": round(estimate.route_s, 3)} if estimate.route_s > 0 else None


def limits_as_json(proof: "Proof") -> list[dict[str, Any]]:
    return [
        {"limit": c.limit, "found": rounded(c.nearest.distance), "required": rounded(c.required), "unit": c.unit}
        for c in proof.checks
        if math.isfinite(c.nearest.distance)
    ]


def proof_as_json(proof: "Proof") -> dict[str, Any]:
    least = proof.clearance
    return {"least": rounded(least.distance), "to": least.what, "at": [rounded(value) for value in least.place]}


def findings_as_json(findings: "Iterable[Finding]") -> list[dict[str, Any]]:
    return [{name: value for name, value in asdict(each).items() if name != "remedies"} for each in findings]


def rounded(value: float) -> float:
    return round(float(value), 6)
