"""Write NAME-1.plan and so on, a battery each."""

from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any

from ipoa_mission.files import make_folder, write_atomically
from ipoa_mission.flight.flight import Flight, as_text, write_files
from ipoa_mission.flight.flight_summary import rounded
from ipoa_mission.forecast.contingency.energy_budget import budget_of
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.report.number_format import seconds


def parts_panel(parts: Sequence[Forecast], names: Sequence[str]) -> str:
    head = "".join(f'<th scope="col">{name}</th>' for name in ("flight", "items", "takes", "energy", "left"))
    rows = ""
    for name, part in zip(names, parts, strict=True):
        budget = budget_of(part)
        left = None if budget is None else budget.left(budget.used.between)
        cells = (
            str(len(part.mission.items)),
            seconds(part.estimate.total_s),
            "" if budget is None else str(budget.used),
            "" if left is None else f"{left.likely:.0%}",
        )
        rows += f'<tr><th scope="row">{escape(name)}</th>{"".join(f"<td>{escape(cell)}</td>" for cell in cells)}</tr>'
    note = (
        f"One battery is not enough for the whole flight: it is flown in {len(parts)} flights, a battery each, "
        "one after the other. Each begins as the whole does, and continues where the one before returned."
    )
    table = f"<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"
    return (
        f'<section><h2>Flights</h2><p class="note">{note}</p><div class="scroll" tabindex="0">{table}</div></section>'
    )


def write_parts(
    whole: Flight, parts: Sequence[Forecast], summary: dict[str, Any], folder: Path, report: bool = False
) -> tuple[Path, ...]:
    """Write the parts without the whole, which needs several batteries.

    `summary` goes to NAME.json; `report`: also NAME.html.

    Raises:
        BadInput: the folder cannot be written.
    """
    make_folder(folder)
    written, digests = list[Path](), dict[str, str]()
    for plan, part in zip(names_of(whole, parts, folder), parts, strict=True):
        files, own = write_files(part.mission, folder, plan.stem)
        written += files
        digests |= own
    about = folder / f"{whole.name}.json"
    write_atomically(about, as_text(summary | {"sha256": digests}))
    if report:
        from ipoa_mission.report.page import PageNotes, report_html

        panel = parts_panel(parts, [path.name for path in names_of(whole, parts, folder)])
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
