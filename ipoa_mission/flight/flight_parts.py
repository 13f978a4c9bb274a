"""Plan a flight of several batteries, and write NAME-1.plan and so on."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from ipoa_mission.files import make_folder, write_atomically
from ipoa_mission.flight.flight import Flight, plan_regardless_of_battery
from ipoa_mission.flight.flight_files import write_several
from ipoa_mission.flight.flight_summary import rounded
from ipoa_mission.forecast.contingency.energy_budget import budget_of
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.progress import Progress, silent
from ipoa_mission.routing.battery_split import split_flight
from ipoa_mission.scenario import Scenario
from ipoa_mission.wind import Wind


def plan_for_batteries(
    scenario: Scenario, *, wind: Wind | None = None, seed: int = 0, progress: Progress = silent
) -> tuple[Flight, tuple[Forecast, ...]]:
    """Return the whole, and the fewest flights with a battery each.

    Raises BadInput without a battery, else as `plan_flight`.
    """
    with threadpool_limits(1, "blas"):
        flight = plan_regardless_of_battery(scenario if wind is None else scenario.in_wind(wind), seed, progress)
        return flight, split_flight(flight.forecast)


def write_parts(
    whole: Flight, parts: Sequence[Forecast], summary: dict[str, Any], folder: Path, report: bool = False
) -> tuple[Path, ...]:
    """Write the parts, `summary` as NAME.json, and for `report` NAME.html. Raises BadInput."""
    make_folder(folder)
    plans = names_of(whole, parts, folder)
    missions = ((plan.stem, part.mission, None) for plan, part in zip(plans, parts, strict=True))
    *written, about = write_several(missions, folder, whole.name, summary)
    if report:
        from ipoa_mission.report.page import PageNotes, report_html
        from ipoa_mission.report.panels.tables import parts_panel

        panel = parts_panel(parts, [path.name for path in plans])
        page = report_html(whole.forecast, whole.plan, notes=PageNotes(whole.remarks, whole.findings, panel))
        written.append(folder / f"{whole.name}.html")
        write_atomically(written[-1], page)
    return (*written, about)


def names_of(whole: Flight, parts: Sequence[Forecast], folder: Path) -> list[Path]:
    return [folder / f"{whole.name}-{number}.plan" for number in range(1, len(parts) + 1)]


def parts_summary(whole: Flight, parts: Sequence[Forecast]) -> dict[str, Any]:
    flights = []
    for path, part in zip(names_of(whole, parts, Path()), parts, strict=True):
        budget = budget_of(part)
        assert budget is not None, "it was split by its energy"
        taken = budget.used.between
        left = budget.left(taken)
        flights.append({
            "file": path.name,
            "items": len(part.mission.items),
            "time_s": rounded(part.estimate.total_s),
            "energy_wh": [rounded(wh) for wh in taken],
            "left": None if left is None else [rounded(share) for share in left],
        })  # fmt: skip
    return whole.summary() | {"flights": flights}
