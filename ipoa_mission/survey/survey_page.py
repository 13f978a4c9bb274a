from collections.abc import Sequence
from html import escape
from urllib.parse import quote

from ipoa_mission.report.number_format import seconds
from ipoa_mission.report.page import page_of
from ipoa_mission.report.panels.headline import verdict, warnings
from ipoa_mission.report.seen import dangers, follow
from ipoa_mission.survey.survey_panel import survey_panel
from ipoa_mission.survey.survey_plan import SurveyFlight, SurveyPlan


def survey_html(plan: SurveyPlan, names: Sequence[str], remarks: Sequence[str]) -> str:
    """`names`: of the flights' files in the same folder."""
    whole = sum(flight.forecast.estimate.total_s for flight in plan.flights)
    flights = "".join(_flight(flight, name) for name, flight in zip(names, plan.flights, strict=True))
    parts = {
        "title": escape(plan.scenario.name),
        "subtitle": f"Survey in {len(names)} flights, {seconds(whole)} together",
        "warnings": warnings([], [], remarks, plan.scenario.remarks),
        "survey": survey_panel(plan, names),
        "flights": flights,
    }
    return page_of("survey.html", parts)


def _flight(flight: SurveyFlight, name: str) -> str:
    forecast = flight.forecast
    course = follow(forecast.estimate.track, forecast.world.airspace)
    proof = forecast.proof_if_known
    judged = verdict(proof, forecast.promise_if_known, dangers(course, forecast.world), flight.findings)
    link = f'<a href="{quote(name)}.html">{escape(name)}</a>'
    return f"<h3>{link}: {seconds(forecast.estimate.total_s)}</h3>{judged}"
