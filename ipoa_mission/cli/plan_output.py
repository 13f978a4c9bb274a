from collections.abc import Iterable, Sequence
from pathlib import Path

from ipoa_mission.cli.output import print_lines, print_table
from ipoa_mission.flight.flight import Flight
from ipoa_mission.forecast.contingency.energy_budget import budget_of
from ipoa_mission.forecast.deviation.promise import Promise
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.mission.waypoints_file import TAKEOFF_LOST
from ipoa_mission.wind import Wind


def print_planned(flight: Flight, written: Iterable[Path]) -> None:
    print_lines(*describe(flight))
    print_lines(f"written: {', '.join(map(str, written))}", TAKEOFF_LOST)


def describe(flight: Flight) -> list[str]:
    mission, estimate = flight.mission, flight.estimate
    firmware = mission.autopilot.checked_for(mission.firmware_version)
    lines = [
        f"{flight.name}: {flight.plan.cost.length:.1f} m, {len(mission.items)} items, for {firmware}",
        *promised(flight.promise),
        f"estimated {estimate.total_s:.1f} s",
        *wind_words(flight.forecast.wind),
    ]
    lines += [] if flight.budget is None else flight.budget.words
    warnings = [words for f in flight.findings for words in (str(f), *([f"hint: {f.hint}"] if f.hint else []))]
    return [*lines, *warnings, *(f"note: {remark}" for remark in flight.notes)]


def wind_words(wind: Wind) -> list[str]:
    return [f"wind {wind}"] if wind.strongest > 0 else []


def print_parts(whole: Flight, parts: Sequence[Forecast], written: Iterable[Path]) -> None:
    print_lines(*describe(whole))
    rows = []
    for number, part in enumerate(parts, 1):
        budget = budget_of(part)
        assert budget is not None, "it was split by its energy"
        left = budget.left(budget.used.between)
        share, takes = "" if left is None else f"{left.likely:.0%}", str(budget.used.between)
        rows.append((str(number), str(len(part.mission.items)), f"{part.estimate.total_s:.1f}", takes, share))
    print_table(f"{len(parts)} flights, a battery each", ["flight", "items", "takes\ns", "takes\nWh", "left"], rows)
    print_lines(f"written: {', '.join(map(str, written))}")


def promised(promise: Promise | None) -> list[str]:
    kept = None if promise is None else promise.clearance
    if promise is None or kept is None:
        return []
    return [f"least clearance, to {kept.to} at item {kept.item}: {kept.words(promise.confidence)}"]
