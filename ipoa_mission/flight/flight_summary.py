"""The parts of NAME.json: what is told of a flight to machines. The same flight gives the same numbers."""

import math
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from ipoa_mission.centimeters import down, up

if TYPE_CHECKING:  # `check` and `estimate` tell some of it, and do without what plans
    from collections.abc import Iterable

    from ipoa_mission.finding import Finding
    from ipoa_mission.forecast.deviation.promise import Kept, Promise
    from ipoa_mission.forecast.energy_budget import Budget
    from ipoa_mission.forecast.timing.estimate import Estimate
    from ipoa_mission.planning.proof import Proof
    from ipoa_mission.routing.assemble import Option
    from ipoa_mission.scenario import Scenario
    from ipoa_mission.vehicles.energy.consumption import Interval

MILLIMETRES = 1000


def clearance_as_json(promise: "Promise | None") -> dict[str, Any]:
    """The least clearance that the flights keep on the way, and to what at which item; empty if nobody knows.

    `elsewhere` is where less than required is kept, and the promise is not about: take-off, ending and given places.
    """
    kept = None if promise is None else promise.clearance
    if promise is None:
        return {}
    confidence = "nominal" if promise.confidence is None else round(promise.confidence, 4)
    others = [{"part": one.part, "limit": one.limit} | _kept_as_json(one) for one in promise.elsewhere]
    elsewhere = {"elsewhere": others} if others else {}
    return elsewhere if kept is None else _kept_as_json(kept) | {"confidence": confidence} | elsewhere


def _kept_as_json(kept: "Kept") -> dict[str, Any]:
    """To the millimetre: what is kept rounded down and what is required up, as in words."""
    return {
        "required_m": up(kept.required, MILLIMETRES),
        "nominal_m": down(kept.nominal, MILLIMETRES),
        "kept_m": down(kept.kept, MILLIMETRES),
        "to": kept.to,
        "item": kept.item,
    }


def passed_over_as_json(scenario: "Scenario") -> list[dict[str, Any]]:
    """What the scenario's maps have that became no obstacle, counted by file and reason."""
    return [asdict(counted) for counted in scenario.passed_counts]


def energy_as_json(budget: "Budget") -> dict[str, Any]:
    """What a flight takes, low, likely and high [Wh], and the shares of its battery that are left; by item too."""
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
    """The time of the route, the least time on it, and how many times that it takes; None where there is no route."""
    route = estimate.route
    if not route.seconds > 0:
        return None
    return {"seconds": round(route.seconds, 3), "least": round(route.least, 3), "ratio": round(route.ratio, 4)}


def option_as_json(option: "Option", mode: str) -> dict[str, Any]:
    """A way to choose waypoints, and whether it is the one that `mode` names."""
    return {
        "mode": option.mode,
        "waypoints": len(option.route.points),
        "spline": option.route.spline,
        "seconds": option.seconds,
        "ratio": option.ratio,
        "deviation": option.deviation,
        "flies_clear": option.flies_clear,
        "chosen": option.mode == mode,
        **({"passed_over": option.passed_over} if option.passed_over else {}),
    }


def limits_as_json(proof: "Proof") -> list[dict[str, Any]]:
    """How near a path comes to each limit that it has."""
    return [
        {"limit": c.limit, "found": rounded(c.nearest.distance), "required": rounded(c.required), "unit": c.unit}
        for c in proof.checks
        if math.isfinite(c.nearest.distance)
    ]


def proof_as_json(proof: "Proof") -> dict[str, Any]:
    """The least clearance of a path, to what and where."""
    least = proof.clearance
    return {"least": rounded(least.distance), "to": least.what, "at": [rounded(value) for value in least.place]}


def findings_as_json(findings: "Iterable[Finding]") -> list[dict[str, Any]]:
    """What a check found, each with its severity."""
    return [{name: one for name, one in asdict(each).items() if name != "remedies"} for each in findings]


def rounded(value: float) -> float:
    """To the millionth."""
    return round(float(value), 6)
