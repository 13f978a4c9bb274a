"""Check the battery, progress in wind, and RTL and LAND at each second."""

from collections.abc import Iterator, Sequence

import numpy as np

from ipoa_mission.autopilot.returning import Contingency
from ipoa_mission.errors import MissionError
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.forecast.contingency.contingencies import lands_by_choice, to_return_instead, who_lands
from ipoa_mission.forecast.contingency.contingency_paths import GROUND, ContingencyPaths, ReturnLeg
from ipoa_mission.forecast.contingency.energy_budget import RETURN_HINT, budget_of
from ipoa_mission.forecast.contingency.shortfalls import (
    find_shortfalls,
    nearest_of,
    nearest_of_legs,
    try_return_altitudes,
)
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.wind import CALM, Wind


def check_energy(forecast: Forecast) -> Iterator[Finding]:
    if forecast.world.vehicle.battery is None or not forecast.mission.items:
        return
    if (budget := budget_of(forecast)) is None or budget.battery is None:
        return
    if (short := budget.shortage) is not None:
        left = (item.left for item in budget.items if item.left is not None)
        number = next((n for n, share in enumerate(left) if share.likely < budget.battery.reserve), None)
        seq = None if number is None else budget.items[number].seq
        words = f"{short}" if seq is None else f"{short}; not enough from item {seq} on"
        yield Finding("battery-short", Severity.ERROR, seq, words, short.hint)
        return
    if budget.eats_reserve:
        taken, usable = budget.used.between, budget.battery.usable_wh
        needs = f"the flight needs {taken.low:.0f} to {taken.high:.0f} Wh (nine flights in ten)"
        words = f"{needs}; the battery has {usable:.0f} Wh above its reserve"
        learned = forecast.mission.vehicle or forecast.world.vehicle.learned
        hint = (
            "the energy is estimated from the airframe alone: `learn` narrows it from logs of the vehicle (--vehicle)"
        )
        is_learned = learned is not None and learned.energy_ratio is not None
        yield Finding("battery-unsure", Severity.WARNING, None, words, None if is_learned else hint)
    if (late := budget.no_return) is not None:
        severity = Severity.ERROR if budget.plans_returns else Severity.WARNING
        yield Finding("battery-no-return", severity, late.seq, str(late), RETURN_HINT if budget.plans_returns else None)


def check_wind(forecast: Forecast) -> Iterator[Finding]:
    if not forecast.mission.items or not forecast.wind.strongest > 0:
        return
    for wind in dict.fromkeys((forecast.wind, forecast.wind.as_strong_as_may_be())):
        if (why := _why_not(forecast, wind)) is not None and _why_not(forecast, CALM) is None:
            words, hint = f"in wind up to {wind.strongest:g} m/s: {why}", "fly in less wind, slower, or another way"
            yield Finding("wind-too-strong", Severity.ERROR, None, words, hint)
            return


def _why_not(forecast: Forecast, wind: Wind) -> str | None:
    try:
        Forecast(forecast.given, forecast.scenario, wind, forecast.left_out).predicted(noise_free=True)
    except MissionError as error:
        return str(error)
    return None


def check_failsafe_return(forecast: Forecast) -> Iterator[Finding]:
    if not forecast.mission.items:
        return
    paths = forecast.cached(ContingencyPaths)
    if len(paths.stops().times) < 2:
        return
    if (why := paths.why_unknown()) is not None:
        yield Finding("return-too-near", Severity.WARNING, None, f"RTL on the way was not checked: {why}")
        return
    samples = paths.samples(Contingency.RTL)
    begin, end = forecast.guarantee.flight.cruise_span
    checked = ~samples.clear & (samples.times >= begin) & (samples.times <= end)
    near = np.where(samples.possible[..., None] & checked[:, None, None], samples.near - paths.required, 0.0)
    braking = near[:, :, : ReturnLeg.RETURNS].min(axis=2, keepdims=True)
    near[:, :, ReturnLeg.RETURNS :][near[:, :, ReturnLeg.RETURNS :] >= braking - 0.02] = 0.0  # [m], rounding
    for legs, verb, order in (  # the descent is a leg of the mission
        (range(ReturnLeg.RETURNS), "brakes and climbs", "RTL or pause"),
        (range(ReturnLeg.RETURNS, ReturnLeg.RETURNS + 1), "flies home", "RTL"),
    ):
        short = near[:, :, legs.start : legs.stop].min(axis=(1, 2))
        if (short < 0.0).any():
            seqs = np.unique(paths.stops().seqs_at(samples.times[short < 0.0]))
            worst = nearest_of_legs(paths, samples, int(np.argmin(short)), legs)
            words = f"{name_items(seqs.tolist())}: {order} on the way there {verb} {worst.words()}"
            hint = _remedy(paths) if legs.start == ReturnLeg.RETURNS else None
            yield Finding("return-too-near", Severity.WARNING, int(seqs[0]), words, hint)


def _remedy(paths: ContingencyPaths) -> str | None:
    by = paths.mission.autopilot.parameter_table.return_height
    short = list(find_shortfalls(paths, Contingency.RTL))
    higher, left = try_return_altitudes(paths, paths.forecast, short)[0]
    if any(shortfall.part >= ReturnLeg.RETURNS for shortfall in left):
        return None
    value = higher.given.parameters[by.name]
    return f"{by.name} = {value:.0f} makes it clear, in the vehicle and under [vehicle.parameters]"


def name_items(seqs: Sequence[int]) -> str:
    """3, 4, 5 and 7 are "items 3 to 5, 7"."""
    runs = np.split(np.array(seqs), np.flatnonzero(np.diff(seqs) > 1) + 1)
    words = ", ".join(str(run[0]) if len(run) == 1 else f"{run[0]} to {run[-1]}" for run in runs)
    return f"item{'' if len(seqs) == 1 else 's'} {words}"


def check_failsafe_landing(forecast: Forecast) -> Iterator[Finding]:
    """Warn where such a landing would come down on something."""
    if not forecast.mission.items or not lands_by_choice(forecast):
        return
    paths = forecast.cached(ContingencyPaths)
    if len(paths.stops().times) < 2:
        return
    samples = paths.samples(Contingency.LAND)
    unclear = np.flatnonzero(((samples.near < paths.required) & (samples.which != GROUND)).any(axis=(1, 2)))
    if len(unclear):
        seqs = np.unique(paths.stops().seqs_at(samples.times[unclear]))
        worst = unclear[np.argmin(samples.slack[unclear])]
        kept = nearest_of(paths, Contingency.LAND, samples, int(worst))
        words = f"{name_items(seqs.tolist())}: LAND on the way there, by {who_lands(forecast)}, descends {kept.words()}"
        yield Finding("land-too-near", Severity.WARNING, int(seqs[0]), words, to_return_instead(forecast))
