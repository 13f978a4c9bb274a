"""What a planned flight is like, in a few lines for a human."""

from ipoa_mission.cli.checking import route_in_words
from ipoa_mission.flight import Flight
from ipoa_mission.tube.promise import Promise


def describe(flight: Flight) -> list[str]:
    """The plan in a few lines."""
    mission, estimate = flight.mission, flight.estimate
    lines = [
        f"{flight.name}: {flight.plan.cost.length:.1f} m, {len(mission.items)} items, for {mission.autopilot}",
        *promised(flight.promise),
        f"estimated {estimate.total_s:.1f} s; QGroundControl would say {estimate.qgroundcontrol_s:.0f} s",
        *route_in_words(estimate),
    ]
    if flight.energy is not None:
        lines.append(f"energy {flight.energy.energy_wh:.1f} Wh, {flight.energy.mean_w:.0f} W on average")
    return [*lines, *(f"note: {remark}" for remark in flight.remarks)]


def promised(promise: Promise | None) -> list[str]:
    """The clearance that is kept, in a line; nothing where none is known."""
    kept = None if promise is None else promise.clearance
    if promise is None or kept is None:
        return []
    return [f"least clearance, to {kept.to} at item {kept.item}: {kept.words(promise.confidence)}"]


ROUTE_COLUMNS = [
    "",
    "mode",
    "waypoints",
    "takes\ns",
    "times the\ncurve's least",
    "leaves the\ncurve by, m",
    "keeps its limits",
]


def route_rows(flight: Flight) -> list[tuple[str, ...]]:
    """What each way to choose waypoints would come to, quickest first; the chosen one is marked."""
    return [
        (
            "*" if option.mode == flight.scenario.route.mode else " ",
            option.mode + (" (splines)" if option.route.spline and option.mode != "spline" else ""),
            str(len(option.route.points)),
            f"{option.seconds:.1f}",
            f"{option.ratio:.2f}",
            f"{option.deviation:.1f}",
            "yes" if option.flies_clear else "no: flown, it comes too close",
        )
        for option in flight.options
    ]
