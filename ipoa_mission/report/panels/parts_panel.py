from collections.abc import Sequence
from html import escape

from ipoa_mission.forecast.contingency.energy_budget import budget_of
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.report.number_format import seconds

HEAD = ("flight", "items", "takes", "energy", "left")


def parts_panel(parts: Sequence[Forecast], names: Sequence[str]) -> str:
    head = "".join(f'<th scope="col">{name}</th>' for name in HEAD)
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
