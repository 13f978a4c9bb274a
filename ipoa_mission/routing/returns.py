"""Returns planned away: a return altitude at which RTL is clear from every second of the flight."""

import math
from collections.abc import Iterator

from ipoa_mission.checks.unsafe import Unsafe
from ipoa_mission.checks.way_home import HEIGHT_STEP, HIGHEST
from ipoa_mission.forecast.endings import EndingRow, Endings
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.vehicles.ending import Ending

MOST_TRIES = 8
GIVE_UP = 'set [safety] returns = "warn" to be warned only'


def with_clear_returns(forecast: Forecast) -> Forecast:
    """The same mission on a vehicle that returns so high that RTL keeps what is required, whenever it is ordered.

    The altitude is the lowest of every five metres above home that is found; none is changed where RTL is clear.

    Raises:
        Unsafe: no altitude helps; with the stretch, and what is in the way.
    """
    if not (unclear := _unclear(forecast)):
        return forecast
    if brakes := [row for row in Endings(forecast).braking() if not row.clear]:
        raise _refusal(brakes, "where it brakes", "fly slower (vehicle.cruise_speed)")
    by, height = forecast.mission.autopilot.book.return_height, 0.0
    ceiling = forecast.world.planning.max_height_above_ground
    highest = HIGHEST if ceiling is None else min(HIGHEST, ceiling)
    for _ in range(MOST_TRIES):
        if any(row.goal == "unknown" for row in unclear):
            break
        wanted = max(_height_over(row, forecast) for row in unclear)
        height = max(height + HEIGHT_STEP, HEIGHT_STEP * math.ceil(wanted / HEIGHT_STEP))
        if height > highest:
            break
        raised = forecast.given.with_parameters({by.name: by.spelled(height)})
        forecast = Forecast(raised, forecast.scenario, forecast.wind)
        if not (unclear := _unclear(forecast)):
            return forecast
    raise _refusal(unclear, f"and no {by.name} up to {highest:g} m changes that", "move the start")


def raised_returns(forecast: Forecast) -> Iterator[str]:
    """That its vehicle needs another return altitude, where it does."""
    by, given = forecast.mission.autopilot.book.return_height, forecast.world.vehicle.autopilot_parameters()
    if by.name in forecast.given.parameters and by.name not in given:
        value, highest = forecast.given.parameters[by.name], forecast.world.airspace.bounds.upper[2]
        beyond = f", above the upper bound of {highest:g} m" if value * by.unit > highest else ""
        yield (
            f"RTL is clear from every second with {by.name} = {value:g} in the vehicle{beyond} "
            f"({forecast.world.name}.params; `fly --set-params` writes it)"
        )


def _refusal(unclear: list[EndingRow], words: str, helps: str) -> Unsafe:
    worst = min(unclear, key=lambda row: row.least_m)
    kept = f"keeps {worst.least_m:.2f} m of {worst.to}, {worst.required_m:.2f} m required"
    return Unsafe(
        f"RTL from {worst.from_s:.1f} to {worst.to_s:.1f} s after arming "
        f"{kept if math.isfinite(worst.least_m) else worst.to}, {words}",
        hint=f"{helps}, or {GIVE_UP}",
    )


def _unclear(forecast: Forecast) -> list[EndingRow]:
    return [row for row in Endings(forecast).rows(Ending.RTL, timed=False) if not row.clear]


def _height_over(row: EndingRow, forecast: Forecast) -> float:
    """How high above home a return at least is that does not come so near to what is in the way."""
    book = forecast.mission.autopilot.book
    if row.to == "the ground":
        now = book.complete(forecast.mission.parameters)[book.return_height.name] * book.return_height.unit
        return now + row.required_m - row.least_m
    tops = {body.name: float(body.bounds[1, 2]) for body in Endings(forecast).roomy.airspace.obstacles}
    return tops[row.to] + row.required_m
