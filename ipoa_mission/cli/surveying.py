import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import typer

from ipoa_mission.cli.groups import FlownByOptions, LinkOptions, SearchOptions
from ipoa_mission.cli.interrupting import confirm, reporting_interrupt
from ipoa_mission.cli.options import LogSystemOption
from ipoa_mission.cli.output import notes, print_json, print_lines, print_table, progress_bar
from ipoa_mission.errors import NothingThere, OptionConflict

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from ipoa_mission.cli.mission_source import Job
    from ipoa_mission.link.logbook import FlightRecord
    from ipoa_mission.scenario import Scenario
    from ipoa_mission.survey.survey_flight import Flown, Survey

#: the job as flown, remarks, the flight
Piloted: TypeAlias = "tuple[Job, tuple[str, ...], FlightRecord]"
#: with every frame in a log
Pilot: TypeAlias = "Callable[[Job, Path], Piloted]"
OPTION = Path("--survey")  # begins errors without a scenario
EACH_BY_ITSELF = "plan first, then fly the flights one by one: ipoa-mission fly NAME-1.plan --link URL"


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
        from ipoa_mission.scenario.scenario_file import read_scenario, read_table, scenario_of
        from ipoa_mission.scenario.survey_section import USUAL_HEIGHT, USUAL_SPACING

        keys = {"height": "height_above_ground", "gsd": "gsd_cm"}
        options = ("height", "line_spacing", "width", "camera", "gsd")
        asked_for = {name: value for name in options if (value := getattr(self, name)) is not None}
        if self.survey is None:
            if asked_for:
                raise OptionConflict("expected with --survey", place=f"--{next(iter(asked_for)).replace('_', '-')}")
            if path is None:
                raise OptionConflict("expected a scenario, or an area: --survey AREA")
            return read_scenario(path)
        table = (
            {"name": self.survey.stem.removesuffix(".osm"), "home": _home_beside(self.survey)}
            if path is None
            else read_table(path)
        )
        own = table.pop("survey", {})
        asked = dict(own) if isinstance(own, dict) else {}
        asked |= {keys.get(name, name): value for name, value in asked_for.items()}
        if asked.keys().isdisjoint({"height_above_ground", "gsd_cm"}):
            asked["height_above_ground"] = USUAL_HEIGHT
        if asked.keys().isdisjoint({"line_spacing", "camera"}):
            asked["line_spacing"] = USUAL_SPACING
        for other in ("polygon", "line"):
            asked.pop(other, None)
        rest = {key: value for key, value in table.items() if key not in ("start", "goal", "via")}
        is_beside = path is None or path.parent == Path()
        area = self.survey if is_beside else self.survey.absolute()
        return scenario_of(rest | {"survey": asked | {"area": str(area)}}, path or OPTION)


def _home_beside(area: Path) -> dict[str, float]:
    import shapely

    from ipoa_mission.maps.map_reader import read_features

    for feature in read_features(area):
        corners = shapely.get_coordinates(feature.shape)
        if len(corners):
            longitude, latitude = corners[0].tolist()
            return {"latitude_deg": latitude, "longitude_deg": longitude}
    raise NothingThere("expected an area, not a map without one", place=area)


def plan_here(
    scenario: "Scenario", search: SearchOptions, flown_by: FlownByOptions, flown: "Sequence[Flown]" = ()
) -> "Survey":
    from ipoa_mission.survey.survey_flight import plan_survey

    with reporting_interrupt("nothing was written"), progress_bar("planning") as show:
        return plan_survey(scenario=scenario, wind=flown_by.air, seed=search.seed, flown=flown, progress=show)


def print_survey(survey: "Survey", written: list[Path]) -> None:
    lines, rows = describe(survey), flight_rows(survey)
    columns = ["file", "lines", "photos", "items", "takes\ns", "energy\nWh", "least clearance\nm"]
    if survey.plan.section.starts is not None:
        columns.append("from")
        rows = [(*row, begins_at(survey, n)) for n, row in enumerate(rows)]
    print_lines(*lines)
    print_table("flights, in this order", columns, rows)
    print_lines(f"written: {', '.join(map(str, written))}")


def describe(survey: "Survey") -> list[str]:
    from ipoa_mission.centimeters import down
    from ipoa_mission.cli.plan_output import wind_words

    plan, first = survey.plan, survey.flights[0].mission
    seen, sight = plan.coverage, plan.sight
    firmware = first.autopilot.checked_for(first.firmware_version)
    heights = f"{sight.least:.1f}" + (f" to {sight.least + sight.band:.1f}" if sight.band else "")
    photos = "" if sight.trigger is None else f", {plan.photos} photos, one each {sight.trigger:.1f} m or less"
    inside = "nothing outside" if seen.outside_m < 0.005 else f"up to {seen.outside_m:.1f} m outside"
    hectares = f"{plan.area.shape.area / 1e4:.2f} ha"
    told = [f"covers {down(100 * seen.share):.2f} % of the visible part of {hectares}; {inside}"]
    if flown := plan.flown:
        told.append(
            f"as flown, with corners cut and passed: {down(100 * flown.share):.2f} %, {flown.outside_m:.1f} m outside"
        )
    overlaps = [f"photos overlap by {plan.overlaps} at least"] if str(plan.overlaps or "") else []
    return [
        f"{survey.name}: {len(plan.tour.swaths)} lines {sight.spacing:.1f} m apart, {heights} m above ground, "
        f"for {firmware}{photos}",
        *told,
        *overlaps,
        f"estimated {survey.total_s:.1f} s in {len(survey.flights)} flight{'s' if len(survey.flights) > 1 else ''}",
        *wind_words(survey.flights[0].wind),
        *survey.warnings,
        *notes(survey.notes),
    ]


def flight_rows(survey: "Survey") -> list[tuple[str, ...]]:
    from ipoa_mission.centimeters import down

    rows = list[tuple[str, ...]]()
    for name, flight in zip(survey.names, survey.plan.flights, strict=True):
        energy, kept = flight.forecast.energy, flight.forecast.promise.clearance
        photos = survey.plan.sight.photos_of(flight.tour)
        rows.append(
            (
                f"{name}.plan",
                str(len(flight.tour.swaths)),
                str(photos),
                str(len(flight.forecast.mission.items)),
                f"{flight.forecast.estimate.total_s:.1f}",
                "" if energy is None else f"{energy.energy_wh:.1f}",
                "" if kept is None else f"{down(kept.kept):.2f} to {kept.to}",
            )
        )
    return rows


def begins_at(survey: "Survey", n: int) -> str:
    return "east {:.0f}, north {:.0f} m".format(*survey.plan.begin_of(survey.plan.flights[n]))


def write_survey(survey: "Survey", out: Path, report: bool, force: bool, as_json: bool) -> list[Path]:
    """Write the files. Raises BadInput."""
    from ipoa_mission.cli.overwriting import expect_plans

    expect_plans(out, dict.fromkeys((survey.name, *survey.names)), report, force, ask=not as_json)
    return [*survey.write(out), *(survey.report(out) if report else ())]


def expect_flyable(survey: "Survey", log: Path | None, is_on_link: bool) -> None:
    """Refuse one log for several flights, and a link without a terminal. Raises BadInput."""
    count = len(survey.names)
    if count > 1 and log is not None:
        message = f"expected one flight, not {count}"
        raise OptionConflict(message, hint="without --log each has a log next to its mission", place="--log")
    if count > 1 and is_on_link and not sys.stdin.isatty():
        words = f"--link: expected a terminal to confirm battery changes between {count} flights"
        raise OptionConflict(words, hint=EACH_BY_ITSELF)


def fly_survey(
    survey: "Survey",
    pilot: "Pilot",
    on_link: LinkOptions,
    out: Path,
    written: list[Path],
    as_json: bool,
    link: str | None,
) -> None:
    """Fly in sequence, each on a confirmed charged battery; stop after an incomplete flight."""
    from ipoa_mission.cli.flown_output import flight_as_json, next_steps, print_flown
    from ipoa_mission.cli.mission_source import Job
    from ipoa_mission.files import unused
    from ipoa_mission.survey.survey_flight import survey_as_json

    if not as_json:
        print_survey(survey, written)
    flown, why, hint = list[dict[str, Any]](), "", ""
    for n, (name, forecast) in enumerate(zip(survey.names, survey.flights, strict=True)):
        if n and link is not None and not _is_ready(survey, n):
            why = f"{name} and later flights were not flown"
            break
        usual = out / f"{name}.tlog"
        own = on_link.log or (usual if link is None else unused(usual))
        job, remarks, record = pilot(Job(name, forecast, ()), own)
        written += map(Path, on_link.written(own))
        if as_json:
            told = flight_as_json(job.estimate, record, job.reserves)
            flown.append(told | {"file": f"{name}.plan", **({"remarks": list(remarks)} if remarks else {})})
        else:
            print_flown(job, record, remarks, [own])
        if record.failure:
            why = f"{name} was not flown {'to its end' if record.why_not else 'as forecast'}: {record.failure}"
            hint = next_steps(link, on_link.system, record)
            break
    if as_json:
        about = survey_as_json(survey.plan, survey.names)
        error = {key: words for key, words in (("error", why), ("hint", hint)) if words}
        result = {"survey": about, "flown": flown, "written": [str(path) for path in written], **error}
        print_json(result, indent=None if any("deviations" in one for one in flown) else 2)  # below lines of events
    if why:
        print(f"error: {why}", *([f"hint: {hint}"] if hint else []), sep="\n", file=sys.stderr)
        raise typer.Exit(1)


def _is_ready(survey: "Survey", n: int) -> bool:
    landed, following, home = survey.names[n - 1], survey.names[n], survey.flights[n].mission.home
    is_elsewhere = home != survey.flights[n - 1].mission.home
    place = f"{begins_at(survey, n)} ({home.latitude_deg:.6f}, {home.longitude_deg:.6f})"
    position = f"the vehicle is at {place}, " if is_elsewhere else ""
    words = (
        f"{landed} has landed. Fly {following}: {position}a charged battery is in, and nobody is near the propellers?"
    )
    return confirm(words)
