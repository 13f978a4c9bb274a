"""Whether the battery brings the flight home with its reserve, and an RTL from any second of it."""

from collections.abc import Iterator

from ipoa_mission.finding import Finding, Severity
from ipoa_mission.forecast.energy import NEARER, budget_of
from ipoa_mission.forecast.forecast import Forecast


def check_energy(forecast: Forecast) -> Iterator[Finding]:
    """What the scenario's battery does not give; nothing where it has none."""
    if forecast.world.vehicle.battery is None or not forecast.mission.items:
        return
    budget = budget_of(forecast)
    if budget is None or budget.battery is None:
        return
    if (short := budget.shortage) is not None:
        left = (item.left for item in budget.items if item.left is not None)
        number = next((n for n, share in enumerate(left) if share.likely < budget.battery.reserve), None)
        seq = None if number is None else budget.items[number].seq
        yield Finding("battery-short", Severity.ERROR, seq, _of_item(seq, str(short)), short.hint)
        return
    if budget.eats_reserve:
        taken = budget.used.between
        words = f"the flight takes {taken.low:.1f} to {taken.high:.1f} Wh, {budget.battery.usable_wh:.1f} Wh are there"
        yield Finding("battery-unsure", Severity.WARNING, None, f"{words} without the reserve")
    if (late := budget.no_return) is not None:
        severity = Severity.ERROR if budget.plans_returns else Severity.WARNING
        yield Finding("battery-no-return", severity, late.seq, str(late), NEARER if budget.plans_returns else None)


def _of_item(seq: int | None, words: str) -> str:
    return words if seq is None else f"{words}; not enough from item {seq} on"
