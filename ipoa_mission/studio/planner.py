"""The process that plans for the studio: `python -m ipoa_mission.studio.planner`."""

import copy
import time
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from ipoa_mission.checks.check import check
from ipoa_mission.checks.positions import refuse_unsound
from ipoa_mission.checks.unsafe import refuse_errors
from ipoa_mission.errors import MissionError
from ipoa_mission.files import read_text, unused
from ipoa_mission.finding import Finding
from ipoa_mission.flight.flight import Flight, plan_flight
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.mission.files import parse_mission, write_mission
from ipoa_mission.mission.mission_file import MissionFile
from ipoa_mission.planning.sketch import sketch_path
from ipoa_mission.scenario import Scenario, parse_scenario
from ipoa_mission.scenario.read import parse_toml, scenario_of
from ipoa_mission.studio.answers import Progress, Written
from ipoa_mission.studio.edits import apply_changes
from ipoa_mission.studio.handed import mission_over, planned_over
from ipoa_mission.studio.harness import Answer, Job, Order, Subject, work
from ipoa_mission.studio.judged import checked, mission_world, opened
from ipoa_mission.studio.planned import expected, planned, sketched
from ipoa_mission.studio.refused import refused
from ipoa_mission.studio.replay import replayed
from ipoa_mission.studio.requests import Change
from ipoa_mission.studio.view import world_of
from ipoa_mission.vehicles.autopilot import autopilot_named

CHANGES: TypeAdapter[tuple[Change, ...]] = TypeAdapter(tuple[Change, ...])
TELL_EVERY_S = 0.1  # progress is told no more often


def look(order: Order, answer: Answer) -> None:
    """What the map shows of a scenario."""
    answer(world_of(_scenario(order["text"], order["path"]), order["revision"]))


def sketch(order: Order, answer: Answer) -> None:
    """A coarse path, of the scenario as it is or as it would be."""
    begun = time.perf_counter()
    if order["changes"]:
        table = copy.deepcopy(_table(order["text"], order["path"]))
        apply_changes(table, CHANGES.validate_python(order["changes"]))
        scenario = scenario_of(table, Path(order["path"]))
    else:
        scenario = _scenario(order["text"], order["path"])
    sketch = sketch_path(scenario)
    answer(sketched(sketch, scenario, order["revision"], order["number"], time.perf_counter() - begun))


def judge(order: Order, answer: Answer) -> None:
    """An open mission: its map, its items, what the check finds, and its flight as expected."""
    begun, revision, path = time.perf_counter(), order["revision"], Path(order["path"])
    file, forecast = _mission(order)
    answer(mission_world(forecast, revision))
    answer(opened(file, forecast, revision, order["worlds"], order["world"]))
    findings, flies = checked(_findings(file, forecast), forecast, revision)
    answer(findings)
    if flies:
        answer(expected(forecast, path.stem, revision, time.perf_counter() - begun))
        if order["log"] is not None:
            answer(replayed(Path(order["log"]), forecast, revision))


def hand_over_mission(order: Order, answer: Answer) -> None:
    """The open mission, for the process that flies it.

    Raises:
        MissionError: the check finds errors, or it has no time.
    """
    file, forecast = _mission(order)
    warnings = refuse_errors(_findings(file, forecast))
    refuse_unsound(forecast.given)
    mission_over(Path(order["path"]).stem, forecast, warnings).write(Path(order["file"]))


class PlanWorker:
    """Plans flights, and keeps the last one, to write its files or to hand it over."""

    def __init__(self) -> None:
        self._flight: Flight | None = None

    def plan(self, order: Order, answer: Answer) -> None:
        """The proved flight."""
        revision, begun, told_at = order["revision"], time.perf_counter(), 0.0

        def progress(share: float, words: str) -> None:
            nonlocal told_at
            if time.perf_counter() - told_at > TELL_EVERY_S:
                told_at = time.perf_counter()
                answer(Progress(revision=revision, share=share, words=words))

        self._flight = None
        scenario = _scenario(order["text"], order["path"])
        try:
            flight = plan_flight(scenario, seed=order["seed"], progress=progress)
        except MissionError as error:
            answer(refused(error, scenario, revision))
        else:
            self._flight = flight
            answer(planned(flight, revision, time.perf_counter() - begun))

    def write(self, order: Order, answer: Answer) -> None:
        """The flight's files, its report among them."""
        flight, folder = self._expect_flight(), Path(order["folder"])
        files, report = flight.write(folder), folder / f"{flight.name}.html"
        flight.report(report)
        answer(Written(files=tuple(file.name for file in (*files, report))))

    def detach(self, order: Order, answer: Answer) -> None:
        """The flight's mission as a file of its own, over nothing."""
        flight, folder = self._expect_flight(), Path(order["folder"])
        target = unused(folder / f"{flight.name}-edited.plan")
        write_mission(flight.mission, target)
        answer(Written(files=(target.name,)))

    def hand_over(self, order: Order, answer: Answer) -> None:
        """The flight, for the process that flies it."""
        planned_over(self._expect_flight()).write(Path(order["file"]))

    def _expect_flight(self) -> Flight:
        if self._flight is None:
            raise MissionError("there is no proved plan", hint="plan first")
        return self._flight

    def jobs(self, _: object) -> Mapping[str, tuple[Job, Subject]]:
        """What can be asked."""
        return {
            "look": (look, "scenario"),
            "sketch": (sketch, "sketch"),
            "judge": (judge, "scenario"),
            "hand over mission": (hand_over_mission, "flight"),
            "detach": (self.detach, "file"),
            "plan": (self.plan, "plan"),
            "write": (self.write, "file"),
            "hand over": (self.hand_over, "flight"),
        }


def _mission(order: Order) -> tuple[MissionFile, Forecast]:
    """The open mission, in the world and on the autopilot that the page names."""
    world = None if order["world"] is None else read_text(Path(order["world"]))
    return _mission_in(order["text"], order["path"], world, order["world"], order["autopilot"])


@lru_cache(maxsize=1)
def _mission_in(
    text: str, path: str, world_text: str | None, world_path: str, autopilot: str | None
) -> tuple[MissionFile, Forecast]:
    world = None if world_text is None else _scenario(world_text, world_path)
    flies = None if autopilot is None else autopilot_named(autopilot)
    if flies is None and world is not None and Path(path).suffix.lower() == ".waypoints":
        flies = world.vehicle.autopilot  # whom such a file does not say
    file = parse_mission(Path(path), text, flies)
    return file, Forecast(file.mission, world)


def _findings(file: MissionFile, forecast: Forecast) -> tuple[Finding, ...]:
    return check(forecast, read=file.findings)


@lru_cache(maxsize=4)
def _table(text: str, path: str) -> dict[str, Any]:
    return parse_toml(text, Path(path))


@lru_cache(maxsize=2)
def _scenario(text: str, path: str) -> Scenario:
    return parse_scenario(text, Path(path))


if __name__ == "__main__":
    work(PlanWorker().jobs)
