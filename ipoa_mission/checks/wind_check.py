"""Check that the vehicle can fly in the scenario's wind."""

from collections.abc import Iterator

from ipoa_mission.errors import MissionError
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.wind import CALM, Wind


def check_wind(forecast: Forecast) -> Iterator[Finding]:
    wind = forecast.wind
    if not forecast.mission.items or not wind.strongest > 0.0:
        return
    for one in dict.fromkeys((wind, wind.as_strong_as_may_be())):
        why = _why_not(forecast, one)
        if why is not None and _why_not(forecast, CALM) is None:
            words = f"in wind up to {one.strongest:g} m/s: {why}"
            yield Finding("wind-too-strong", Severity.ERROR, None, words, "fly in less wind, slower, or another way")
            return


def _why_not(forecast: Forecast, wind: Wind) -> str | None:
    try:
        Forecast(forecast.given, forecast.scenario, wind, forecast.left_out).predicted(sure=True)
    except MissionError as error:
        return str(error)
    return None
