"""The planner process: each function is a job."""

import copy
import os
import time
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import TypeAdapter

from ipoa_mission import BadInput, Flight, Forecast, MissionError, MissionFile, plan_flight, read_flights
from ipoa_mission.autopilot.autopilot import autopilot_named
from ipoa_mission.checks.check import check
from ipoa_mission.checks.unsafe import refuse_errors
from ipoa_mission.files import MISSIONS, read_text
from ipoa_mission.mission.mission_io import parse_mission, read_by_items, write_mission
from ipoa_mission.mission.positions import refuse_unsound
from ipoa_mission.planning.planner import sketch_path
from ipoa_mission.report.compare import compare_flight, flown_track
from ipoa_mission.scenario import Scenario, parse_scenario
from ipoa_mission.scenario.scenario_file import parse_toml, scenario_of
from ipoa_mission.studio.answers import Progress, Trouble, Written
from ipoa_mission.studio.edits import apply_changes
from ipoa_mission.studio.flight_answers import Replay
from ipoa_mission.studio.handed import HandedOver, mission_over, planned_over, survey_over
from ipoa_mission.studio.mission_view import check_answer, mission_answer, mission_world
from ipoa_mission.studio.plan_answers import expected, planned, sketched, strips_of
from ipoa_mission.studio.processes import Answer, Job, JobOrder, Subject, Worker
from ipoa_mission.studio.remedies import plan_trouble, text_trouble
from ipoa_mission.studio.requests import Change
from ipoa_mission.studio.survey_view import area_of, coarse_survey, planned_survey
from ipoa_mission.studio.view import line_of, world_of
from ipoa_mission.survey.survey_flight import Survey, plan_survey
from ipoa_mission.survey.survey_task import sketch_survey
from ipoa_mission.terminal import round_finite

CHANGES: TypeAdapter[tuple[Change, ...]] = TypeAdapter(tuple[Change, ...])


def look(order: JobOrder, answer: Answer) -> None:
    table = _table(order["text"], order["path"])
    try:
        scenario = _scenario(order["text"], order["path"])
    except MissionError as error:
        answer(area_of(table, None))
        answer(text_trouble(error, table, order["path"]))
    else:
        answer(area_of(table, scenario))
        answer(world_of(scenario))


def sketch(order: JobOrder, answer: Answer) -> None:
    if order["changes"]:
        table = copy.deepcopy(_table(order["text"], order["path"]))
        apply_changes(table, CHANGES.validate_python(order["changes"]))
        scenario = scenario_of(table, Path(order["path"]))
    else:
        scenario = _scenario(order["text"], order["path"])
    try:
        if "survey" not in scenario.added:
            answer(sketched(sketch_path(scenario), scenario, order["number"]))
        else:
            answer(coarse_survey(sketch_survey(scenario), scenario, order["number"]))
    except MissionError as error:
        answer(plan_trouble(error, scenario, of="sketch"))


def judge(order: JobOrder, answer: Answer) -> None:
    file, forecast = _mission(order)
    answer(mission_world(forecast))
    answer(mission_answer(file, forecast, order["worlds"], order["world"]))
    checked = check_answer(check(forecast, read=file.findings), forecast)
    answer(checked)
    if checked.timeless is None:
        answer(expected(forecast, Path(order["path"]).stem))
        if order["log"] is not None:
            answer(replayed(Path(order["log"]), forecast))


class PlanWorker:
    def __init__(self) -> None:
        self._plan: Flight | Survey | None = None
        self._flights = list[HandedOver]()  # of the plan

    def plan(self, order: JobOrder, answer: Answer) -> None:
        shown_at = 0.0

        def progress(share: float, words: str) -> None:
            nonlocal shown_at
            if time.perf_counter() - shown_at > 0.1:  # [s]
                shown_at = time.perf_counter()
                answer(Progress(share=share, words=words))

        self._plan = None
        self._flights = []
        scenario = _scenario(order["text"], order["path"])
        is_survey = "survey" in scenario.added
        logs = tuple(map(Path, order["flown"])) if is_survey else ()
        try:
            if not is_survey:
                self._plan = flight = plan_flight(scenario, seed=order["seed"], progress=progress)
                self._flights = [planned_over(flight)]
                answer(planned(flight, self._flights[0].proof))
            else:
                self._plan = plan_survey(scenario=scenario, seed=order["seed"], flown=logs, progress=progress)
                self._flights = survey_over(self._plan)
                answer(planned_survey(self._plan, [flight.proof for flight in self._flights], logs))
        except MissionError as error:
            if not logs or not isinstance(error, BadInput):
                answer(plan_trouble(error, scenario))
                return
            message = str(error).replace(f"{logs[0].parent}{os.sep}", "")
            answer(Trouble(of="edit", message=message, hint="all of the survey is planned again"))
            self.plan(order | {"flown": []}, answer)

    def contingencies(self, order: JobOrder, answer: Answer) -> None:
        forecast = _mission(order)[1] if _is_mission(order) else self._planned(order["flight"]).forecast
        for strip in strips_of(forecast, order["flight"]):
            answer(strip)

    def write(self, order: JobOrder, answer: Answer) -> None:
        files = self._expect_plan().write(order["folder"], report=True)
        answer(Written(files=tuple(file.name for file in files)))

    def detach(self, order: JobOrder, _: Answer) -> None:
        write_mission(self._planned(order["flight"]).forecast.mission, Path(order["file"]))

    def hand_over(self, order: JobOrder, _: Answer) -> None:
        if _is_mission(order):
            file, forecast = _mission(order)
            warnings = refuse_errors(check(forecast, read=file.findings))
            refuse_unsound(forecast.mission_as_read)
            handed = mission_over(Path(order["path"]).stem, forecast, warnings)
        else:
            handed = self._planned(order["flight"])
        handed.write(Path(order["file"]))

    def _expect_plan(self) -> Flight | Survey:
        if self._plan is None:
            raise MissionError("there is no proved plan", hint="plan first", code="not-planned")
        return self._plan

    def _planned(self, n: int) -> HandedOver:
        self._expect_plan()
        if not 0 <= n < len(self._flights):
            raise MissionError(f"expected one of {len(self._flights)}", code="no-such-item", place=f"flight {n + 1}")
        return self._flights[n]

    def jobs(self, _: object) -> Mapping[str, tuple[Job, Subject]]:
        return {
            "look": (look, "scenario"),
            "sketch": (sketch, "sketch"),
            "judge": (judge, "scenario"),
            "detach": (self.detach, "file"),
            "plan": (self.plan, "plan"),
            "contingencies": (self.contingencies, "plan"),
            "write": (self.write, "file"),
            "hand over": (self.hand_over, "flight"),
        }


def _is_mission(order: JobOrder) -> bool:
    return Path(order["path"]).suffix.lower() in MISSIONS


def _mission(order: JobOrder) -> tuple[MissionFile, Forecast]:
    world = None if order["world"] is None else read_text(Path(order["world"]))
    return _mission_in(order["text"], order["path"], world, order["world"], order["autopilot"])


@lru_cache(maxsize=1)
def _mission_in(
    text: str, path: str, world_text: str | None, world_path: str, autopilot: str | None
) -> tuple[MissionFile, Forecast]:
    world = None if world_text is None else _scenario(world_text, world_path)
    chosen = None if autopilot is None else autopilot_named(autopilot)
    if chosen is None and world is not None and Path(path).suffix.lower() == ".waypoints":
        chosen = world.vehicle.autopilot  # such a file does not name its autopilot
    file = read_by_items(Path(path), parse_mission(Path(path), text, chosen))
    return file, Forecast(file.mission, world)


@lru_cache(maxsize=4)
def _table(text: str, path: str) -> dict[str, Any]:
    return parse_toml(text, Path(path))


@lru_cache(maxsize=2)
def _scenario(text: str, path: str) -> Scenario:
    return parse_scenario(text, Path(path))


_read_flights = lru_cache(maxsize=2)(read_flights)


def replayed(log: Path, forecast: Forecast) -> Replay:
    flown = _read_flights(log)
    flight = next((flight for flight in flown.flights if flight.in_mission), None)
    if flight is None:
        raise MissionError("expected a flight in the mission mode", code="log-incomplete", place=log.name)
    forecast = forecast.on(flight.firmware_version)
    record = flight.record(forecast.mission)
    track = flown_track(forecast, record)
    if track is None:
        raise MissionError("expected a flight with positions", code="log-incomplete", place=log.name)
    compared = compare_flight(forecast.estimate, record)
    count = len(track.times)
    shown = np.unique(np.linspace(0, count - 1, min(1000, count)).round().astype(int))
    several = [f"the first of {len(flown.flights)} flights in it"] if len(flown.flights) > 1 else []
    return Replay(
        log=log.name,
        line=line_of(forecast.frame, track.points[shown]),
        times=tuple(track.times[shown].round(2).tolist()),
        items=compared.legs,
        estimated_s=round(compared.estimated_total_s, 1),
        flown_s=round_finite(compared.flown_total_s, 1),
        remarks=(*flown.remarks, *several),
    )


if __name__ == "__main__":
    Worker(PlanWorker().jobs).run()
