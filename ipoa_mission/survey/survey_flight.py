"""Plan a survey, or the rest of one, and write its files."""

import logging
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import shapely
from pydantic import ValidationError
from threadpoolctl import threadpool_limits

from ipoa_mission import Forecast, Scenario, Wind
from ipoa_mission.checks.unsafe import expect_plannable
from ipoa_mission.errors import BadInput, NothingThere
from ipoa_mission.files import make_folder
from ipoa_mission.geometry import Plane, Points
from ipoa_mission.maps.map_reader import read_features
from ipoa_mission.mission.mission_io import write_files
from ipoa_mission.mission.waypoints_file import left_out
from ipoa_mission.progress import Progress, silent
from ipoa_mission.report.summary import passed_over_as_json
from ipoa_mission.routing.planned_returns import return_remarks
from ipoa_mission.routing.repairs import raise_way_home_remarks, slow_landings_remarks
from ipoa_mission.scenario.explain import explained
from ipoa_mission.scenario.scenario_file import read_table, scenario_of
from ipoa_mission.survey.resume import runs_in_order
from ipoa_mission.survey.survey_plan import SurveyFlight, SurveyPlan, coverage_lines, plan_flights, rest_of
from ipoa_mission.survey.survey_section import USUAL_HEIGHT, USUAL_SPACING, SurveySection, survey_of
from ipoa_mission.unread import unread_as_json

#: The system id chooses one vehicle of a log.
Flown: TypeAlias = str | Path | tuple[str | Path, int]
log = logging.getLogger(__name__)


@dataclass(frozen=True, repr=False)
class Survey:
    """A planned survey; `plan_survey` makes it.

    Attributes:
        plan: lines, coverage, and flights.
        seed: of the random numbers.
        remarks: notes for the user.
    """

    plan: SurveyPlan
    seed: int
    remarks: tuple[str, ...]

    def __repr__(self) -> str:
        return f"<Survey {self.name}: {len(self.plan.tour.swaths)} lines, {len(self.flights)} flights>"

    @property
    def name(self) -> str:
        return self.plan.scenario.name

    @property
    def flights(self) -> tuple[Forecast, ...]:
        return tuple(flight.forecast for flight in self.plan.flights)

    @property
    def names(self) -> tuple[str, ...]:
        count = len(self.flights)
        return (self.name,) if count == 1 else tuple(f"{self.name}-{n}" for n in range(1, count + 1))

    @property
    def notes(self) -> tuple[str, ...]:
        """Return the remarks that are no findings."""
        warned = {*_messages_of_flights(self.plan, _warnings_of), *_more_flights(self.plan)}
        return tuple(words for words in self.remarks if words not in warned)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Return the warnings of its checks, then their hints."""
        messages = _messages_of_flights(self.plan, lambda flight: (finding.message for finding in flight.findings))
        hints = _messages_of_flights(self.plan, lambda flight: (f.hint for f in flight.findings if f.hint))
        return (
            *(f"warning: {words}" for words in messages),
            *(f"hint: {words}" for words in (*hints, *_more_flights(self.plan))),
        )

    @property
    def total_s(self) -> float:
        return sum(forecast.estimate.total_s for forecast in self.flights)

    def write(self, folder: str | Path = ".", report: bool = False) -> tuple[Path, ...]:
        """Write to `folder` .plan, .waypoints, .json of each flight, NAME.json, pages for `report`, together.

        The same survey gives the same bytes.

        Raises:
            BadInput: the folder cannot be written.
        """
        from ipoa_mission.survey.survey_report import forecast_as_json

        folder = Path(folder)
        make_folder(folder)
        pages = self._pages(folder) if report else {}
        if len(self.flights) == 1:
            return write_files([(self.name, self.flights[0].mission, self.summary())], folder, pages)
        parts = []
        for name, forecast in zip(self.names, self.flights, strict=True):
            about = {"name": name, "version": version("ipoa-mission"), **forecast_as_json(forecast)}
            parts.append((name, forecast.mission, about))
        return write_files(parts, folder, pages, whole=(self.name, self.summary()))

    def summary(self) -> dict[str, object]:
        """Return NAME.json in meters, seconds and watt hours."""
        from ipoa_mission.survey.survey_report import forecast_as_json, survey_as_json

        first = self.flights[0]
        firmware = first.mission.autopilot.facts(first.mission.firmware_version)
        return {
            "name": self.name,
            "version": version("ipoa-mission"),
            "seed": self.seed,
            **({"wind": first.wind.as_json()} if first.wind.strongest > 0 else {}),
            **(forecast_as_json(first) if len(self.flights) == 1 else {"firmware": firmware}),
            "survey": survey_as_json(self.plan, self.names),
            "remarks": list(self.remarks),
            "passed_over": passed_over_as_json(self.plan.scenario),
            "unread": unread_as_json(self.plan.scenario.unread),
        }

    def _pages(self, folder: Path) -> dict[Path, str]:
        from ipoa_mission.report.page import PageNotes, report_html
        from ipoa_mission.survey.survey_report import survey_layers, survey_panel

        panel = survey_panel(self.plan, self.names)
        layers = survey_layers(self.plan)
        of_flights = {*_messages_of_flights(self.plan, _repairs)}
        of_all = [*_more_flights(self.plan), *(words for words in self.notes if words not in of_flights)]
        pages = dict[Path, str]()
        for name, flight in zip(self.names, self.plan.flights, strict=True):
            notes = PageNotes(flight.findings, (*_repairs(flight), *of_all), panel, layers)
            pages[folder / f"{name}.html"] = report_html(flight.forecast, notes)
        return pages


def describe(survey: Survey) -> list[str]:
    plan = survey.plan
    sight = plan.sight
    first = survey.flights[0]
    firmware = first.mission.autopilot.checked_for(first.mission.firmware_version)
    heights = f"{sight.least:.1f}" + (f" to {sight.least + sight.band:.1f}" if sight.band else "")
    photos = "" if sight.trigger is None else f", {plan.photos} photos, one each {sight.trigger:.1f} m or less"
    flights = f"{len(survey.flights)} flight{'s' if len(survey.flights) > 1 else ''}"
    return [
        f"{survey.name}: {len(plan.tour.swaths)} lines {sight.spacing:.1f} m apart, {heights} m above ground, "
        f"for {firmware}{photos}",
        *coverage_lines(plan),
        f"estimated {survey.total_s:.1f} s in {flights}",
        *([f"wind {first.wind}"] if first.wind.strongest > 0 else []),
        *survey.warnings,
        *(f"note: {remark}" for remark in survey.notes),
    ]


def plan_survey(
    area: "Plane | list[Any] | str | Path | None" = None,
    camera: str | Mapping[str, Any] | None = None,
    *,
    scenario: Scenario,
    wind: Wind | None = None,
    seed: int = 0,
    flown: Sequence[Flown] = (),
    progress: Progress = silent,
    **keys: Any,
) -> Survey:
    """Plan lines that see an area, and checked, timed flights that fly them, split by battery.

    Args:
        area: corners as `polygon` of [survey], or a map with polygons; None: the scenario's [survey], changed by
            `keys`.
        camera: as in [survey]; None: no photos.
        scenario: home, world, vehicle and limits.
        wind: replaces the scenario's.
        seed: of the random numbers; the same arguments give the same survey.
        flown: logs (`.tlog`, `.bin`, `.ulg`) of earlier flights of this survey; the rest is planned, with some overlap,
            as NAME-rest. A pair (log, system id) chooses a vehicle, else the first multicopter counts.
        progress: called with the share done and a message.
        keys: other keys of [survey], such as `line_spacing`, `height_above_ground`, `gsd_cm`, `direction_deg`.

    Returns:
        The survey, whose `write` makes the files.

    Raises:
        BadInput: a wrong key or map; nothing is left, or nothing was flown.
        NoPath, NoRoute: obstacles leave nothing of the area, or no safe way was found.
        NotEnoughBattery: a line cannot be flown with the reserve.
        Unsafe: a mission fails a check.

    Example:
        >>> from ipoa_mission import plan_survey, read_scenario
        >>> field = [[0.0, 40.0], [80.0, 40.0], [80.0, 90.0], [0.0, 90.0]]
        >>> over = {"line_spacing": 15.0, "height_above_ground": 70.0, "direction_deg": 90.0}
        >>> survey = plan_survey(field, scenario=read_scenario("missions/sitl.toml"), **over)
        >>> len(survey.plan.tour.swaths), survey.plan.coverage.share > 0.999
        (4, True)
    """
    if area is not None or camera is not None or keys:
        scenario = _with_survey(scenario, area, camera, keys)
    scenario = scenario.in_wind(wind)
    expect_plannable(scenario)
    with threadpool_limits(1, "blas"):  # more threads only wait, and round differently
        plan = plan_flights(scenario, seed, progress)
        plan, before = _replan(plan, scenario, flown, seed) if flown else (plan, [])
    log.info("%s: %d lines in %d flights", scenario.name, len(plan.tour.swaths), len(plan.flights))
    return Survey(plan, seed, tuple(dict.fromkeys((*before, *_remarks(plan, scenario)))))


def _replan(first: SurveyPlan, scenario: Scenario, flown: Sequence[Flown], seed: int) -> tuple[SurveyPlan, list[str]]:
    from ipoa_mission import read_flights  # imports all of the link

    pairs = [log if isinstance(log, tuple) else (log, None) for log in flown]
    logs = [(str(name), read_flights(name, system)) for name, system in pairs]
    paths = {name: [*_paths([flight.flown_in_mission() for flight in log.flights], scenario)] for name, log in logs}
    rest = rest_of(first, [path for log in paths.values() for path in log], seed)
    rest = replace(rest, scenario=rest.scenario.model_copy(update={"name": f"{scenario.name}-rest"}))
    length, left = (sum(swath.length for swath in plan.tour.swaths) for plan in (first, rest))
    reason = "no flight in it follows the lines of this survey"
    if left >= length:
        raise BadInput(reason, place=", ".join(paths))
    source = "the log" if len(paths) == 1 else "the logs"
    ground = first.scenario.airspace.ground
    remarks = [f"by {source}, {length - left:.0f} m of {length:.0f} m of lines were flown before"]
    for name, flights in paths.items():
        if not any(runs_in_order(first.tour, path, first.sight, ground) for path in flights):
            remarks.append(f"{name}: {reason}")
    return rest, remarks + [f"{name}: {remark}" for name, log in logs for remark in log.remarks]


def _paths(flights: Iterable[Sequence[tuple[float, float, float]]], scenario: Scenario) -> Iterator[Points]:
    for positions in filter(None, flights):
        latitude, longitude, height = np.array(positions).T
        yield scenario.frame.to_local(latitude, longitude, scenario.frame.home.altitude + height)


def scenario_over(area: Path, file: Path | None, keys: Mapping[str, Any]) -> Scenario:
    """Return a file's scenario, or one at the area's begin, with a survey of a map's `area` by `keys` of [survey]."""
    table = {"name": area.stem.removesuffix(".osm"), "home": _begin(area)} if file is None else read_table(file)
    written = table.pop("survey", {})
    section = (dict(written) if isinstance(written, dict) else {}) | dict(keys)
    if section.keys().isdisjoint({"height_above_ground", "gsd_cm"}):
        section["height_above_ground"] = USUAL_HEIGHT
    if section.keys().isdisjoint({"line_spacing", "camera"}):
        section["line_spacing"] = USUAL_SPACING
    section = {key: value for key, value in section.items() if key not in ("polygon", "line")}
    section["area"] = str(area if file is None or file.parent == Path() else area.absolute())
    rest = {key: value for key, value in table.items() if key not in ("start", "goal", "via")}
    return scenario_of(rest | {"survey": section}, file or Path("--survey"))


def _begin(area: Path) -> dict[str, float]:
    for feature in read_features(area):
        for longitude, latitude in shapely.get_coordinates(feature.shape).tolist():
            return {"latitude_deg": latitude, "longitude_deg": longitude}
    raise NothingThere("expected an area, not a map without one", place=area)


def _with_survey(scenario: Scenario, area: Any, camera: Any, keys: Mapping[str, Any]) -> Scenario:
    current = survey_of(scenario) if area is None else None
    table: dict[str, Any] = {} if current is None else current.model_dump(exclude_unset=True)
    table |= keys
    if camera is not None:
        table["camera"] = camera
    if isinstance(area, str | Path):
        table["area"] = area
    elif area is not None:
        table["polygon"] = area.tolist() if hasattr(area, "tolist") else area
    try:
        section = SurveySection.model_validate(table)
        places = Scenario.model_validate({"home": scenario.home, "survey": section})
    except ValidationError as error:
        raise explained(error, table, SurveySection, "survey.") from error
    asking = scenario.model_copy(update={"survey": section, "start": places.start, "goal": places.goal, "via": ()})
    return asking.with_files_read()


def _messages_of_flights(plan: SurveyPlan, messages_of: Callable[[SurveyFlight], Iterable[str]]) -> Iterator[str]:
    flights_by_words = dict[str, list[int]]()
    for n, flight in enumerate(plan.flights, 1):
        for words in dict.fromkeys(messages_of(flight)):
            flights_by_words.setdefault(words, []).append(n)
    for words, numbers in flights_by_words.items():
        name = "flight" if len(numbers) == 1 else "flights"
        yield words if len(numbers) == len(plan.flights) else f"{name} {', '.join(map(str, numbers))}: {words}"


def _warnings_of(flight: SurveyFlight) -> Iterator[str]:
    return (words for finding in flight.findings for words in (finding.message, finding.hint) if words)


def _more_flights(plan: SurveyPlan) -> tuple[str, ...]:
    unsure = any(finding.code == "battery-unsure" for flight in plan.flights for finding in flight.findings)
    if not unsure:
        return ()
    return (f"flights = {len(plan.flights) + 1} under [survey] leaves more in each battery",)


def _repairs(flight: SurveyFlight) -> Iterator[str]:
    forecast = flight.forecast
    yield from raise_way_home_remarks(forecast.mission)
    yield from slow_landings_remarks(forecast)
    yield from return_remarks(forecast)
    yield from left_out(forecast.mission)


def _remarks(plan: SurveyPlan, requested: Scenario) -> Iterator[str]:
    yield from _messages_of_flights(plan, _warnings_of)
    yield from _more_flights(plan)
    speed = plan.scenario.vehicle.cruise_speed
    full_speed = requested.vehicle.cruise_speed
    if speed != full_speed:
        yield f"flown at {speed:g} m/s: at {full_speed:g} m/s flights would come too near"
    if plan.overlaps is not None:
        yield from plan.overlaps.falls_short(*plan.sight.overlaps)
    yield from _messages_of_flights(plan, _repairs)
    section = survey_of(requested)
    if section is not None:
        yield from (thing.words for thing in section.unread(requested.frame))
    yield from plan.scenario.remarks
