"""The page of a forecast, with the findings of its check."""

from collections.abc import Sequence

from ipoa_mission.checks.check import check
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.mission.flight_record import FlightRecord
from ipoa_mission.planning.planner import Plan
from ipoa_mission.report.page import PageNotes, report_html


def page_of(
    forecast: Forecast, plan: Plan | None = None, flight: FlightRecord | None = None, remarks: Sequence[str] = ()
) -> str:
    return report_html(forecast, PageNotes(check(forecast), remarks), plan, flight)
