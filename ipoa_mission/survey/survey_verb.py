import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import typer

from ipoa_mission.cli.groups import FileOutput
from ipoa_mission.cli.interrupting import ChangesMade
from ipoa_mission.cli.planners import FlyJob, FlyOptions, PlanOptions
from ipoa_mission.errors import OptionConflict
from ipoa_mission.options import LogSystemOption, flag
from ipoa_mission.terminal import confirm, print_json, print_lines, print_table

if TYPE_CHECKING:
    from ipoa_mission.scenario import Scenario
    from ipoa_mission.survey.survey_flight import Survey

ONE_BY_ONE = "plan first, then fly the flights one by one: ipoa-mission fly NAME-1.plan --link URL"


@dataclass
class SurveyPlanner:
    """Survey options of `plan`; a survey replaces start, goal and via."""

    option: ClassVar = "--survey"
    instead: ClassVar = "an area: --survey AREA"
    about: ClassVar = """
    A scenario with a [survey], or `--survey AREA` with or without one, is planned as lines that cover the area. If one
    battery is not enough there are NAME-1.plan, NAME-2.plan and so on. With `--flown LOG` only the rest is planned, as
    NAME-rest."""

    survey: Annotated[Path | None, flag("--survey", "Survey the whole area in this map (GeoJSON, KML).", "AREA")] = None
    height: Annotated[float | None, flag("--height", "Height of a survey above the ground; default 40.", "M")] = None
    line_spacing: Annotated[
        float | None, flag("--line-spacing", "Spacing of the lines; default 20, or by the camera.", "M")
    ] = None
    width: Annotated[float | None, flag("--width", "Width of a corridor along the lines in this map.", "M")] = None
    camera: Annotated[str | None, flag("--camera", "Camera of the photos.", "NAME")] = None
    gsd: Annotated[float | None, flag("--gsd", "Ground sampling distance, instead of the height.", "CM")] = None
    flown: Annotated[
        list[Path] | None,
        flag("--flown", "Plan the rest of the survey, without the part flown in this log (.tlog, .bin, .ulg).", "LOG"),
    ] = None
    system: LogSystemOption = None

    def scenario(self, path: Path | None) -> "Scenario | None":
        """Return the scenario with the area; without a file home is at its begin."""
        names = {"height": "height_above_ground", "gsd": "gsd_cm"}
        options = ("height", "line_spacing", "width", "camera", "gsd")
        keys = {name: getattr(self, name) for name in options if getattr(self, name) is not None}
        if self.survey is not None:
            from ipoa_mission.survey.survey_flight import scenario_over

            return scenario_over(self.survey, path, {names.get(name, name): value for name, value in keys.items()})
        for name in keys:
            raise OptionConflict("needs --survey", place=f"--{name.replace('_', '-')}")
        return None

    def accepts(self, scenario: "Scenario") -> bool:
        is_survey = "survey" in scenario.added
        if self.flown and not is_survey:
            hint = "for the rest of another mission: ipoa-mission fly --from N"
            raise OptionConflict("expected a survey", hint=hint, place="--flown")
        return is_survey

    def plan(self, scenario: "Scenario", asked: PlanOptions, changes: ChangesMade) -> None:
        survey = self._planned(scenario, asked, changes)
        written = _write(survey, asked.files)
        if asked.files.as_json:
            print_json(survey.summary() | {"written": [str(file) for file in written]})
        else:
            _print(survey, written)

    def fly(self, scenario: "Scenario", asked: FlyOptions, fly_job: FlyJob, changes: ChangesMade) -> None:
        """Fly in sequence, each on a confirmed charged battery; stop after an incomplete flight."""
        if asked.on_vehicle.begin != 1:
            raise OptionConflict("expected a mission, not a survey", hint=ONE_BY_ONE, place="--from")
        survey = self._planned(scenario, asked, changes)
        _expect_flyable(survey, asked)
        _fly(survey, asked, fly_job)

    def _planned(self, scenario: "Scenario", asked: PlanOptions, changes: ChangesMade) -> "Survey":
        from ipoa_mission.survey.survey_flight import plan_survey

        if self.system is not None and not self.flown:
            raise OptionConflict("needs --flown", place="--system")
        logs = [log if self.system is None else (log, self.system) for log in self.flown or ()]
        with changes.planning() as show:
            return plan_survey(
                scenario=scenario, wind=asked.flown_by.air, seed=asked.search.seed, flown=logs, progress=show
            )


def _print(survey: "Survey", written: list[Path]) -> None:
    from ipoa_mission.survey.survey_flight import describe
    from ipoa_mission.survey.survey_plan import flight_table

    print_lines(*describe(survey))
    print_table("flights, in this order", *flight_table(survey.plan, survey.names))
    print_lines(f"written: {', '.join(map(str, written))}")


def _write(survey: "Survey", files: FileOutput) -> list[Path]:
    files.expect_plans(dict.fromkeys((survey.name, *survey.names)))
    return [*survey.write(files.folder, files.report)]


def _expect_flyable(survey: "Survey", asked: FlyOptions) -> None:
    """Refuse one log for several flights, and a link without a terminal."""
    count = len(survey.names)
    if count > 1 and asked.on_link.log is not None:
        message = f"expected one flight, not {count}"
        raise OptionConflict(message, hint="without --log each has a log next to its mission", place="--log")
    if count > 1 and asked.on_vehicle.link is not None and not sys.stdin.isatty():
        words = f"--link: expected a terminal to confirm battery changes between {count} flights"
        raise OptionConflict(words, hint=ONE_BY_ONE)


def _fly(survey: "Survey", asked: FlyOptions, fly_job: FlyJob) -> None:
    from ipoa_mission.cli.flight_output import flight_as_json, next_steps, print_flown
    from ipoa_mission.cli.mission_source import Job

    files = asked.files
    link = asked.on_vehicle.link
    written = _write(survey, files)
    if not files.as_json:
        _print(survey, written)
    results = list[dict[str, Any]]()
    why = ""
    hint = ""
    system: int | None = None
    for n, (name, forecast) in enumerate(zip(survey.names, survey.flights, strict=True)):
        ready = f"Fly {name}: a charged battery is in, and nobody is near the propellers?"
        if n and link is not None and not confirm(f"{survey.names[n - 1]} has landed. {ready}"):
            why = f"{name} and later flights were not flown"
            break
        log = asked.log_of(name)
        flown = fly_job(Job(name, forecast, (), system=system), log)
        system = flown.system  # the next flight is this vehicle's, whatever else is heard
        written += map(Path, asked.on_link.written(log))
        if files.as_json:
            result = flight_as_json(flown.job.estimate, flown.record, flown.job.reserves) | {"file": f"{name}.plan"}
            results.append(result | ({"remarks": list(flown.remarks)} if flown.remarks else {}))
        else:
            print_flown(flown, [log])
        if flown.record.failure:
            how = "to its end" if flown.record.why_not else "as forecast"
            why = f"{name} was not flown {how}: {flown.record.failure}"
            hint = next_steps(link, flown.system, flown.record)
            break
    if files.as_json:
        about = {"survey": survey.summary()["survey"], "flown": results, "written": [*map(str, written)]}
        error = {key: words for key, words in (("error", why), ("hint", hint)) if words}
        print_json(about | error, indent=None if any("deviations" in one for one in results) else 2)  # below events
    if why:
        print(f"error: {why}", *([f"hint: {hint}"] if hint else []), sep="\n", file=sys.stderr)
        raise typer.Exit(1)
