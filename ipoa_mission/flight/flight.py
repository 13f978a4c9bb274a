import logging
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from importlib.metadata import version
from pathlib import Path

from threadpoolctl import threadpool_limits

from ipoa_mission.checks.check import check
from ipoa_mission.checks.unsafe import expect_plannable, refuse_errors, refuse_unclear_returns
from ipoa_mission.errors import BadInput
from ipoa_mission.files import make_folder, write_atomically
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.flight.flight_parts import split_flight
from ipoa_mission.forecast.contingency.energy_budget import Budget, budget_of, refusal_of
from ipoa_mission.forecast.deviation.clearance_guarantee import ClearanceGuarantee
from ipoa_mission.forecast.flight_energy import Consumption
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.timing.estimate import COUNTED_TERMS, Estimate
from ipoa_mission.mission.flight_record import FlightRecord
from ipoa_mission.mission.items import Mission
from ipoa_mission.mission.mission_io import write_files
from ipoa_mission.mission.waypoints_file import left_out
from ipoa_mission.planning.planner import Plan
from ipoa_mission.planning.proof import Proof
from ipoa_mission.progress import Progress, silent
from ipoa_mission.report import summary
from ipoa_mission.routing.attempt import Attempt
from ipoa_mission.routing.planned_returns import return_remarks
from ipoa_mission.routing.refusal import slowed_where_needed_remarks
from ipoa_mission.routing.repairs import raise_way_home_remarks, slow_landings_remarks
from ipoa_mission.routing.seek import by_way_of_the_goal_remarks, plan_with_margins
from ipoa_mission.scenario import Scenario
from ipoa_mission.unread import unread_as_json
from ipoa_mission.wind import Wind

log = logging.getLogger(__name__)


@dataclass(frozen=True, repr=False)
class Flight:
    """A flight as planned by `plan_flight`; a `FlightRecord` is one as flown.

    Attributes:
        plan: the path.
        forecast: of the flight.
        findings: warnings of the check.
        remarks: notes, the warnings first.
        chosen: the route and its forecast.
        parts: the fewest flights with a battery each, if one battery is not enough.
    """

    plan: Plan
    forecast: Forecast
    findings: tuple[Finding, ...]
    remarks: tuple[str, ...]
    chosen: Attempt
    parts: tuple[Forecast, ...] = ()

    def __repr__(self) -> str:
        return f"<Flight {self.name}: {len(self.mission.items)} items, {self.estimate.total_s:.1f} s>"

    @property
    def scenario(self) -> Scenario:
        return self.forecast.world

    @property
    def mission(self) -> Mission:
        return self.forecast.mission

    @property
    def proof(self) -> Proof:
        return self.forecast.proof

    @property
    def guarantee(self) -> ClearanceGuarantee:
        return self.forecast.guarantee

    @property
    def estimate(self) -> Estimate:
        return self.forecast.estimate

    @property
    def energy(self) -> Consumption | None:
        """Return the energy; None without airframe or learned vehicle."""
        return self.forecast.energy

    @property
    def budget(self) -> Budget | None:
        return budget_of(self.forecast)

    @property
    def name(self) -> str:
        return self.scenario.name

    @property
    def names(self) -> tuple[str, ...]:
        """Return the names of its missions."""
        return tuple(f"{self.name}-{number}" for number in range(1, len(self.parts) + 1)) or (self.name,)

    @property
    def notes(self) -> tuple[str, ...]:
        warned = {words for finding in self.findings for words in (finding.message, finding.hint)}
        return tuple(remark for remark in self.remarks if remark not in warned)

    def write(self, folder: str | Path = ".", report: bool = False) -> tuple[Path, ...]:
        """Write to `folder` NAME.plan, .waypoints, .json, .params for parameters, NAME.html for `report`, together.

        With parts the missions are of those. Missions that an earlier NAME.json records are removed unless they were
        edited. The same flight gives the same bytes.

        Raises:
            BadInput: the folder cannot be written.
        """
        folder = Path(folder)
        make_folder(folder)
        pages = {folder / f"{self.name}.html": self._page()} if report else {}
        if not self.parts:
            return write_files([(self.name, self.mission, self.summary())], folder, pages)
        missions = [(name, part.mission, None) for name, part in zip(self.names, self.parts, strict=True)]
        return write_files(missions, folder, pages, whole=(self.name, self.summary()))

    def summary(self) -> dict[str, object]:
        """Return NAME.json in meters, seconds and degrees."""
        plan = self.plan
        energy = self.energy
        budget = self.budget
        parameters = dict(self.mission.parameters)
        items = summary.items_as_json(self.forecast)
        return {
            "name": self.name,
            "version": version("ipoa-mission"),
            "firmware": self.mission.autopilot.facts(self.mission.firmware_version),
            "seed": plan.seed,
            "optimizer": plan.optimizer,
            "evaluations": int(plan.evaluations[-1]),
            "cost": {name: summary.rounded(value) for name, value in asdict(plan.cost).items()},
            "clearance": summary.clearance_as_json(self.guarantee)
            | {"curve": summary.proof_as_json(plan.proof), "legs": summary.proof_as_json(self.proof)},
            "limits": summary.limits_as_json(self.proof),
            "control_points": [[summary.rounded(value) for value in point] for point in plan.curve.control],
            **items,
            "estimate": items["estimate"]
            | {"qgroundcontrol_counts": COUNTED_TERMS, "route": summary.route_summary(self.estimate)},
            **({"wind": self.forecast.wind.as_json()} if self.forecast.wind.strongest > 0 else {}),
            "energy_wh": None if energy is None else summary.rounded(energy.energy_wh),
            **({} if budget is None else {"energy": summary.energy_as_json(budget)}),
            **({"parameters": parameters} if parameters else {}),
            **({"findings": summary.findings_as_json(self.findings)} if self.findings else {}),
            "remarks": list(self.remarks),
            "passed_over": summary.passed_over_as_json(self.scenario),
            "unread": unread_as_json(self.scenario.unread),
            **({"flights": list(map(_part_as_json, self.names, self.parts))} if self.parts else {}),
        }

    def report(self, path: str | Path, record: FlightRecord | None = None) -> None:
        """Write the page of the flight.

        Args:
            path: of an HTML file.
            record: as flown.

        Raises:
            BadInput: the file cannot be written.
        """
        write_atomically(Path(path), self._page(record))

    def _page(self, record: FlightRecord | None = None) -> str:
        from ipoa_mission.report.page import PageNotes, report_html
        from ipoa_mission.report.panels.tables import parts_panel

        panel = parts_panel(self.parts, self.names) if self.parts else ""
        return report_html(self.forecast, PageNotes(self.findings, self.remarks, panel), self.plan, record)


def _part_as_json(name: str, part: Forecast) -> dict[str, object]:
    budget = budget_of(part)
    assert budget is not None, "it was split by its energy"
    energy = budget.used.between
    left = budget.left(energy)
    return {
        "file": f"{name}.plan",
        "items": len(part.mission.items),
        "time_s": summary.rounded(part.estimate.total_s),
        "energy_wh": [summary.rounded(wh) for wh in energy],
        "left": None if left is None else [summary.rounded(share) for share in left],
    }


def plan_flight(scenario: Scenario, *, wind: Wind | None = None, seed: int = 0, progress: Progress = silent) -> Flight:
    """Plan a path, choose waypoints, check and time the mission.

    Args:
        scenario: places, world, vehicle and limits.
        seed: of the random numbers; the same arguments give the same flight.
        wind: replaces the scenario's.
        progress: called with the share done and a message.

    Returns:
        The flight, whose `write` makes the files.

    Raises:
        BadInput: unknown or incomplete optimizer, equal start and goal, or a survey.
        NoPath, NoRoute: no safe way was found.
        Unsafe: the mission fails a check.
        NotEnoughBattery: it would not return with its reserve (planned returns: not from every second).

    Example:
        >>> from ipoa_mission import plan_flight, read_scenario
        >>> flight = plan_flight(read_scenario("missions/sitl.toml"), seed=7)
        >>> flight.proof.is_proved, [path.name for path in flight.write(".")]
        (True, ['sitl.plan', 'sitl.waypoints', 'sitl.json', 'sitl.params'])
    """
    for name, section in scenario.added.items():
        hint = f"use {section.planned_by}, as `ipoa-mission plan` does"
        raise BadInput(f"expected a scenario without a {name}", hint=hint, place=name)
    with threadpool_limits(1, "blas"):  # more threads only wait, and round differently
        flight = plan_regardless_of_battery(scenario.in_wind(wind), seed, progress)
    if (short := refusal_of(flight.forecast)) is not None:
        raise short
    return flight


def plan_regardless_of_battery(scenario: Scenario, seed: int, progress: Progress) -> Flight:
    expect_plannable(scenario)
    world = scenario.airspace
    log.info("%s: %d obstacles, planning by %s", scenario.name, len(world.obstacles), scenario.optimizer.name)
    chosen = plan_with_margins(scenario, seed, progress)
    plan = chosen.plan.judged_by(chosen.scenario)
    forecast = chosen.forecast
    mission = forecast.mission
    log.info("%s: cost %.4f after %d evaluations", scenario.name, plan.history[-1], plan.evaluations[-1])

    findings = check(forecast)
    battery_codes = {"battery-short", "battery-no-return"}  # it may be split
    refuse_errors([finding for finding in findings if finding.code not in battery_codes])
    refuse_unclear_returns(findings, forecast)

    warnings = tuple(finding for finding in findings if finding.severity is Severity.WARNING)
    remarks = [words for finding in warnings for words in (finding.message, finding.hint) if words]
    remarks += slowed_where_needed_remarks(chosen.route)
    remarks += by_way_of_the_goal_remarks(chosen.scenario, scenario)
    if len(mission.items) > len(chosen.draft.mission.items):
        remarks += raise_way_home_remarks(mission)
    remarks += slow_landings_remarks(forecast)
    remarks += return_remarks(forecast)
    remarks += [*chosen.scenario.remarks, *left_out(mission)]
    return Flight(plan, forecast, warnings, tuple(remarks), chosen)


def plan_for_batteries(
    scenario: Scenario, *, wind: Wind | None = None, seed: int = 0, progress: Progress = silent
) -> Flight:
    """As `plan_flight`, with `parts` if one battery is not enough; BadInput: the vehicle has none."""
    with threadpool_limits(1, "blas"):
        flight = plan_regardless_of_battery(scenario.in_wind(wind), seed, progress)
        parts = split_flight(flight.forecast)
    return replace(flight, parts=parts) if len(parts) > 1 else flight


def write_report(
    forecast: Forecast,
    path: str | Path,
    plan: Plan | None = None,
    flight: FlightRecord | None = None,
    remarks: Sequence[str] = (),
) -> None:
    """Write the report on a mission, one page without a server.

    Args:
        forecast: of the mission, in the world of a scenario.
        path: of an HTML file.
        plan: of the mission, if known.
        flight: as flown, if it was.
        remarks: shown first, with the estimate's own.

    Raises:
        BadInput: the folder may not be written.

    Example:
        >>> from ipoa_mission import Forecast, read_mission, read_scenario, write_report
        >>> forecast = Forecast(read_mission("missions/sitl.plan"), read_scenario("missions/sitl.toml"))
        >>> write_report(forecast, "sitl.html")
    """
    from ipoa_mission.report.page import PageNotes, report_html

    write_atomically(Path(path), report_html(forecast, PageNotes(check(forecast), remarks), plan, flight))
