import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import typer

from ipoa_mission.cli.groups import FlownByOptions, LinkOptions, SearchOptions
from ipoa_mission.cli.interrupting import reporting_interrupt
from ipoa_mission.cli.options import LogSystemOption
from ipoa_mission.cli.output import FileOutput, confirm, print_json, print_lines, print_table, progress_bar
from ipoa_mission.errors import NothingThere, OptionConflict

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from ipoa_mission.cli.mission_source import FlownJob, Job
    from ipoa_mission.scenario import Scenario
    from ipoa_mission.survey.survey_flight import Flown, Survey

#: Flies a job; every frame goes to the log.
Pilot: TypeAlias = "Callable[[Job, Path], FlownJob]"


ONE_BY_ONE = "plan first, then fly the flights one by one: ipoa-mission fly NAME-1.plan --link URL"


@dataclass
class SurveyOptions:
    """Options of a survey, which replaces start, goal and via."""

    survey: Annotated[
        Path | None, typer.Option("--survey", metavar="AREA", help="Survey the whole area in this map (GeoJSON, KML).")
    ] = None
    height: Annotated[
        float | None, typer.Option("--height", metavar="M", help="Height of a survey above the ground; default 40.")
    ] = None
    line_spacing: Annotated[
        float | None,
        typer.Option("--line-spacing", metavar="M", help="Spacing of the lines; default 20, or by the camera."),
    ] = None
    width: Annotated[
        float | None, typer.Option("--width", metavar="M", help="Width of a corridor along the lines in this map.")
    ] = None
    camera: Annotated[str | None, typer.Option("--camera", metavar="NAME", help="Camera of the photos.")] = None
    gsd: Annotated[
        float | None, typer.Option("--gsd", metavar="CM", help="Ground sampling distance, instead of the height.")
    ] = None

    flown: Annotated[
        list[Path] | None,
        typer.Option(
            "--flown",
            metavar="LOG",
            help="Plan the rest of the survey, without the part flown in this log (.tlog, .bin, .ulg).",
        ),
    ] = None
    system: LogSystemOption = None

    @property
    def flown_logs(self) -> "list[Flown]":
        if self.system is not None and not self.flown:
            raise OptionConflict("expected with --flown", place="--system")
        return [log if self.system is None else (log, self.system) for log in self.flown or ()]

    def scenario(self, path: Path | None) -> "Scenario":
        """Return the scenario with this survey; without a file home is at the area's begin. Raises BadInput."""
        names = {"height": "height_above_ground", "gsd": "gsd_cm"}
        options = {name: getattr(self, name) for name in ("height", "line_spacing", "width", "camera", "gsd")}
        keys = {names.get(name, name): value for name, value in options.items() if value is not None}
        if self.survey is not None:
            from ipoa_mission.survey.survey_flight import scenario_over

            return scenario_over(self.survey, path, keys, _home_in(self.survey) if path is None else {})
        for name, value in options.items():
            if value is not None:
                raise OptionConflict("expected with --survey", place=f"--{name.replace('_', '-')}")
        if path is None:
            raise OptionConflict("expected a scenario, or an area: --survey AREA")
        from ipoa_mission.scenario.scenario_file import read_scenario

        return read_scenario(path)


def _home_in(area: Path) -> dict[str, float]:
    """Return the first corner of a map's area."""
    import shapely

    from ipoa_mission.maps.map_reader import read_features

    for feature in read_features(area):
        corners = shapely.get_coordinates(feature.shape)
        if len(corners):
            longitude, latitude = corners[0].tolist()
            return {"latitude_deg": latitude, "longitude_deg": longitude}
    raise NothingThere("expected an area, not a map without one", place=area)


def plan_here(
    scenario: "Scenario",
    search: SearchOptions,
    flown_by: FlownByOptions,
    flown: "Sequence[Flown]" = (),
    first_item: int = 1,
) -> "Survey":
    from ipoa_mission.survey.survey_flight import plan_survey

    if first_item != 1:
        raise OptionConflict("expected a mission, not a survey", hint=ONE_BY_ONE, place="--from")
    with reporting_interrupt("nothing was written"), progress_bar("planning") as show:
        return plan_survey(scenario=scenario, wind=flown_by.air, seed=search.seed, flown=flown, progress=show)


def print_survey(survey: "Survey", written: list[Path]) -> None:
    from ipoa_mission.survey.survey_flight import describe, flight_table

    print_lines(*describe(survey))
    print_table("flights, in this order", *flight_table(survey))
    print_lines(f"written: {', '.join(map(str, written))}")


def write_survey(survey: "Survey", files: FileOutput) -> list[Path]:
    """Write the files. Raises BadInput."""
    files.expect_plans(dict.fromkeys((survey.name, *survey.names)))
    return [*survey.write(files.folder), *(survey.report(files.folder) if files.report else ())]


def expect_flyable(survey: "Survey", log: Path | None, is_on_link: bool) -> None:
    """Refuse one log for several flights, and a link without a terminal. Raises BadInput."""
    count = len(survey.names)
    if count > 1 and log is not None:
        message = f"expected one flight, not {count}"
        raise OptionConflict(message, hint="without --log each has a log next to its mission", place="--log")
    if count > 1 and is_on_link and not sys.stdin.isatty():
        words = f"--link: expected a terminal to confirm battery changes between {count} flights"
        raise OptionConflict(words, hint=ONE_BY_ONE)


def fly_survey(survey: "Survey", pilot: Pilot, on_link: LinkOptions, link: str | None, files: FileOutput) -> None:
    """Write its files, and fly in sequence, each on a confirmed charged battery; stop after an incomplete flight."""
    from ipoa_mission.cli.flight_output import flight_as_json, next_steps, print_flown
    from ipoa_mission.cli.mission_source import Job
    from ipoa_mission.files import unused

    written = write_survey(survey, files)
    if not files.as_json:
        print_survey(survey, written)
    results, why, hint = list[dict[str, Any]](), "", ""
    for n, (name, forecast) in enumerate(zip(survey.names, survey.flights, strict=True)):
        if n and link is not None and not _is_ready(survey, n):
            why = f"{name} and later flights were not flown"
            break
        usual = files.folder / f"{name}.tlog"
        log = on_link.log or (usual if link is None else unused(usual))
        flown = pilot(Job(name, forecast, ()), log)
        written += map(Path, on_link.written(log))
        if files.as_json:
            result = flight_as_json(flown.job.estimate, flown.record, flown.job.reserves) | {"file": f"{name}.plan"}
            results.append(result | ({"remarks": list(flown.remarks)} if flown.remarks else {}))
        else:
            print_flown(flown, [log])
        if flown.record.failure:
            how = "to its end" if flown.record.why_not else "as forecast"
            why, hint = (
                f"{name} was not flown {how}: {flown.record.failure}",
                next_steps(link, on_link.system, flown.record),
            )
            break
    if files.as_json:
        about = {"survey": survey.summary()["survey"], "flown": results, "written": [*map(str, written)]}
        error = {key: words for key, words in (("error", why), ("hint", hint)) if words}
        print_json(about | error, indent=None if any("deviations" in one for one in results) else 2)  # below events
    if why:
        print(f"error: {why}", *([f"hint: {hint}"] if hint else []), sep="\n", file=sys.stderr)
        raise typer.Exit(1)


def _is_ready(survey: "Survey", n: int) -> bool:
    from ipoa_mission.survey.survey_flight import begin_in_words

    landed, following, home = survey.names[n - 1], survey.names[n], survey.flights[n].mission.home
    is_elsewhere = home != survey.flights[n - 1].mission.home
    place = f"{begin_in_words(survey.plan, survey.plan.flights[n])} ({home.latitude_deg:.6f}, {home.longitude_deg:.6f})"
    position = f"the vehicle is at {place}, " if is_elsewhere else ""
    words = (
        f"{landed} has landed. Fly {following}: {position}a charged battery is in, and nobody is near the propellers?"
    )
    return confirm(words)
