"""Check that the battery lasts, also for an RTL at any time."""

from collections.abc import Iterator

from ipoa_mission.errors import MissionError
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.forecast.contingency.energy_budget import RETURN_HINT, budget_of
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.wind import CALM, Wind

LEARN_HINT = "the energy is estimated from the airframe alone: `learn` narrows it from logs of the vehicle (--vehicle)"


def check_energy(forecast: Forecast) -> Iterator[Finding]:
    if forecast.world.vehicle.battery is None or not forecast.mission.items:
        return
    if (budget := budget_of(forecast)) is None or budget.battery is None:
        return
    if (short := budget.shortage) is not None:
        left = (item.left for item in budget.items if item.left is not None)
        number = next((n for n, share in enumerate(left) if share.likely < budget.battery.reserve), None)
        seq = None if number is None else budget.items[number].seq
        yield Finding("battery-short", Severity.ERROR, seq, _of_item(seq, str(short)), short.hint)
        return
    if budget.eats_reserve:
        taken, usable = budget.used.between, budget.battery.usable_wh
        needs = f"the flight needs {taken.low:.0f} to {taken.high:.0f} Wh (nine flights in ten)"
        words = f"{needs}; the battery has {usable:.0f} Wh above its reserve"
        learned = forecast.mission.vehicle or forecast.world.vehicle.learned
        hint = None if learned is not None and learned.energy_ratio is not None else LEARN_HINT
        yield Finding("battery-unsure", Severity.WARNING, None, words, hint)
    if (late := budget.no_return) is not None:
        severity = Severity.ERROR if budget.plans_returns else Severity.WARNING
        yield Finding("battery-no-return", severity, late.seq, str(late), RETURN_HINT if budget.plans_returns else None)


def _of_item(seq: int | None, words: str) -> str:
    return words if seq is None else f"{words}; not enough from item {seq} on"


def check_wind(forecast: Forecast) -> Iterator[Finding]:
    wind = forecast.wind
    for one in (
        dict.fromkeys((wind, wind.as_strong_as_may_be())) if forecast.mission.items and wind.strongest > 0 else ()
    ):
        if (why := _why_not(forecast, one)) is not None and _why_not(forecast, CALM) is None:
            words, hint = f"in wind up to {one.strongest:g} m/s: {why}", "fly in less wind, slower, or another way"
            yield Finding("wind-too-strong", Severity.ERROR, None, words, hint)
            return


def _why_not(forecast: Forecast, wind: Wind) -> str | None:
    try:
        Forecast(forecast.given, forecast.scenario, wind, forecast.left_out).predicted(sure=True)
    except MissionError as error:
        return str(error)
    return None
