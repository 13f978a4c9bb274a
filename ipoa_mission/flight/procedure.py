import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, nullcontext, suppress
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from enum import StrEnum
from typing import TYPE_CHECKING, TypeAlias

from ipoa_mission.autopilot.parameters import NO_PARAMETERS, Parameters
from ipoa_mission.checks.check import check
from ipoa_mission.checks.unsafe import NotAtStart, begun_forecast, check_start, refuse_errors, refuse_unclear_returns
from ipoa_mission.errors import MissionError, Unsafe
from ipoa_mission.finding import Finding
from ipoa_mission.flight import preflight
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link.conversations import KeepsChanging, MissionRefused
from ipoa_mission.link.departure import Departure
from ipoa_mission.link.dialogue import NoAnswer, TimeUp
from ipoa_mission.link.messages import Message, MissionType, Position, Result
from ipoa_mission.link.vehicle import Vehicle
from ipoa_mission.mission.flight_record import FlightRecord
from ipoa_mission.mission.items import Mission
from ipoa_mission.progress import Progress, silent

if TYPE_CHECKING:
    from ipoa_mission.forecast.conformance import ConformanceMonitor
    from ipoa_mission.forecast.contingency.contingencies_now import ContingenciesNow
    from ipoa_mission.forecast.contingency.energy_budget import ReserveNow
    from ipoa_mission.scenario import Scenario


class Stage(StrEnum):
    POSITION = "waiting for a position"
    CHECK = "checking the mission against the vehicle"
    PARAMETERS = "setting parameters"
    UPLOAD = "upload"
    RECHECK = "checking the uploaded mission against the vehicle"
    READY = "waiting until it is ready"
    START = "armed and started"
    FLIGHT = "flying"


Stages: TypeAlias = Callable[[Stage], AbstractContextManager[Progress]]
ReportRemark: TypeAlias = Callable[[str], None]


def without_progress(stage: Stage) -> AbstractContextManager[Progress]:
    return nullcontext(silent)


@dataclass(frozen=True)
class ProcedureOptions:
    first: int = 0
    anyway: bool = False
    ignore: Iterable[str] = ()
    set_params: bool = False
    stages: Stages = without_progress
    remark: ReportRemark = lambda words: None
    checked: bool = False  # the forecast, in its world
    depart_at: datetime | None = None


def upload_mission(
    vehicle: Vehicle,
    mission: Mission,
    *,
    anyway: bool = False,
    ignore: Iterable[str] = (),
    stages: Stages = without_progress,
) -> tuple[str, ...]:
    """Check a mission against this vehicle, upload it, and verify each list.

    Args:
        vehicle: from `connect`.
        mission: for this vehicle's autopilot, unless `anyway`.
        anyway: return failed checks as remarks.
        ignore: codes of findings to leave out.
        stages: shows each stage's progress.

    Returns:
        Remarks: warnings, parameters that differ, a disabled fence.

    Raises:
        NotReady, Unsafe, FarFromHome, OutsideOwnFence: armed, would crash, be refused or aborted; nothing was sent.
        MissionError: it was made for another autopilot; or as `Vehicle.upload`.

    Example:
        >>> from ipoa_mission import connect, read_mission, upload_mission
        >>> with connect("udpin:127.0.0.1:14550") as vehicle:
        ...     upload_mission(vehicle, read_mission("missions/sitl.plan"))
        ('the mission assumes default parameters, and the vehicle has COM_LOW_BAT_ACT 3 (not 0)',)
    """
    if not anyway:
        vehicle.state.expect_on_ground()
    with stages(Stage.CHECK):
        remarks = preflight.expect_fit(vehicle, mission, anyway, ignore)
        left = left_lists(vehicle, mission)
    _store(vehicle, mission, anyway, stages)
    with stages(Stage.RECHECK):
        try:
            notes = (*preflight.idle_fence(vehicle, mission), *preflight.parameters_aboard(vehicle, mission).remarks())
        except NoAnswer as unread:
            notes = (f"the vehicle's parameters were not compared with the mission's: {unread}",)
    return (*remarks, *left.values(), *notes)


def _store(vehicle: Vehicle, mission: Mission, anyway: bool, stages: Stages) -> None:
    with stages(Stage.UPLOAD) as show:
        vehicle.upload(replace(mission, autopilot=vehicle.autopilot) if anyway else mission, show, checked=False)


def left_lists(vehicle: Vehicle, mission: Mission) -> dict[MissionType, str]:
    left: dict[MissionType, str] = {}
    for kind, uploaded, words in (
        (MissionType.RALLY, mission.rally, "rally points of another mission: RTL flies to one of them"),
        (MissionType.FENCE, mission.fence, "a fence of another mission: it may end the flight"),
    ):
        try:
            if not uploaded and vehicle.download_items(kind):
                left[kind] = f"the vehicle holds {words}, and that was not checked"
        except (NoAnswer, TimeUp, KeepsChanging, MissionRefused) as unread:
            if not isinstance(unread, MissionRefused) or unread.result != Result.UNSUPPORTED:
                left[kind] = f"it is unknown whether the vehicle holds {words}: {unread}"
    return left


def fly_mission(
    vehicle: Vehicle,
    mission: Mission,
    scenario: "Scenario | None" = None,
    *,
    first: int = 0,
    anyway: bool = False,
    set_params: bool = False,
    stages: Stages = without_progress,
    remark: ReportRemark = lambda words: None,
) -> FlightRecord:
    """Upload a mission, prepare, arm and start the vehicle, and watch it until it is on the ground.

    At the first deviation from the forecast the order in `vehicle.conformance.on_deviation` is given, by default to
    hold, which ends the watch.

    Args:
        vehicle: on the ground and disarmed.
        mission: for its autopilot, unless `anyway`.
        scenario: world in which mission and start are checked.
        first: index in `mission.items`.
        anyway: pass failed checks to `remark`, and fly all the same.
        set_params: write differing parameters of the mission.
        stages: shows each stage's progress.
        remark: called with notes as they arise.

    Returns:
        The record of the flight.

    Raises:
        NotReady: it is armed already, has no position, or cannot be armed.
        FastLanding, LowBattery, NotAtStart, Unsafe, FarFromHome, OutsideOwnFence: a check failed; nothing was armed.
        MissionError: as `upload_mission` and `Vehicle.start`; the vehicle was lost, or holds another mission's rally
            points.

    Example:
        >>> from ipoa_mission import connect, fly_mission, read_mission, read_scenario
        >>> mission = read_mission("missions/sitl.plan")
        >>> with connect("udpin:127.0.0.1:14550") as vehicle:
        ...     fly_mission(vehicle, mission, read_scenario("missions/sitl.toml"), set_params=True).completed
        True
    """
    options = ProcedureOptions(first, anyway, (), set_params, stages, remark)
    return begin_mission(vehicle, load_mission(vehicle, Forecast(mission, scenario), options), options)


def load_mission(vehicle: Vehicle, forecast: Forecast, options: ProcedureOptions) -> Forecast:
    """Write and upload after all checks; return the forecast with version and parameters aboard."""
    mission = forecast.mission_as_read
    vehicle.state.expect_on_ground()
    with options.stages(Stage.POSITION) as show:
        preflight.await_home(vehicle, show)
    with options.stages(Stage.CHECK):
        found = preflight.parameters_aboard(vehicle, mission)
        written = {other.name: other.wanted for other in found.named} if options.set_params else {}
        expected = replace(found, named=()) if written else found
        aboard, remarks = _examine(vehicle, forecast, expected, options, written)
        left = left_lists(vehicle, mission)
        if not options.anyway and MissionType.RALLY in left:
            hint = "clear its lists (ipoa-mission clear), or fly with --anyway"
            raise MissionError(left[MissionType.RALLY], hint, code="other-rally-points")
    if written:
        with options.stages(Stage.PARAMETERS) as show:
            _set_parameters(vehicle, found.named, show, options.remark)
        with options.stages(Stage.CHECK):  # a parameter may be lost
            expected = preflight.parameters_aboard(vehicle, mission)
            aboard, remarks = _examine(vehicle, forecast, expected, options)
    _store(vehicle, mission, options.anyway, options.stages)
    with options.stages(Stage.RECHECK):
        notes = preflight.idle_fence(vehicle, mission)
        parameters = preflight.parameters_aboard(vehicle, mission)
    if parameters != expected:
        with options.stages(Stage.RECHECK):
            aboard, remarks = _examine(vehicle, forecast, parameters, options)
    with suppress(NoAnswer):
        vehicle.link_loss.meanwhile = preflight.without_station(vehicle, vehicle.firmware_version())
    for words in (*remarks, *left.values(), *notes, *parameters.remarks(": --set-params writes it")):
        options.remark(words)
    return aboard


def _with_values(vehicle: Vehicle, forecast: Forecast, parameters: preflight.ParametersAboard) -> Forecast:
    if forecast.mission_as_read.autopilot is not vehicle.autopilot:
        return forecast
    aboard = forecast.on(vehicle.firmware_version())
    values = parameters.values
    return aboard.with_mission(aboard.mission_as_read.with_parameters(values)) if values else aboard


def _examine(
    vehicle: Vehicle,
    forecast: Forecast,
    parameters: preflight.ParametersAboard,
    options: ProcedureOptions,
    written: Parameters = NO_PARAMETERS,
) -> tuple[Forecast, tuple[str, ...]]:
    aboard = _with_values(vehicle, forecast, parameters)
    if not options.anyway:
        if forecast.scenario is not None:
            preflight.expect_same_height(forecast.mission_as_read.home, vehicle.home())
        preflight.expect_slow_landing(forecast, aboard)
    remarks = preflight.expect_fit(vehicle, forecast.mission_as_read, options.anyway, options.ignore, written)
    if aboard is forecast and (options.checked or forecast.scenario is None):
        return aboard, remarks
    before = forecast if options.checked else Forecast(forecast.mission_as_read)
    known = {finding.message for finding in check(before, options.ignore)}
    findings = check(aboard, options.ignore)
    new = [finding for finding in findings if finding.message not in known]
    if not options.anyway:
        _refuse_aboard(aboard, parameters, findings, new)
    return aboard, (*remarks, *(f"with the parameters and version aboard: {finding.message}" for finding in new))


def _refuse_aboard(
    aboard: Forecast, parameters: preflight.ParametersAboard, findings: Sequence[Finding], new: Sequence[Finding]
) -> None:
    try:
        refuse_errors(findings)
        if aboard.scenario is not None:
            refuse_unclear_returns([finding for finding in new if finding.code != "land-too-near"], aboard)
    except Unsafe as unsafe:
        words = f"with the parameters and version aboard: {unsafe}"
        hint = "; or ".join(filter(None, (*parameters.remedies, unsafe.hint)))
        raise Unsafe(words, hint=hint, remedies=unsafe.remedies, known=unsafe.known) from None


def begin_mission(vehicle: Vehicle, forecast: Forecast, options: ProcedureOptions) -> FlightRecord:
    def permit(there: Geodetic) -> None:
        charge = () if options.anyway else preflight.expect_charge(vehicle, forecast, options.first)
        if not options.anyway:
            preflight.expect_home_here(vehicle.state.position, forecast.mission_as_read.home)
        try:
            notes = check_start(forecast.mission_as_read, forecast.scenario, options.first, there)
        except NotAtStart as elsewhere:
            if not options.anyway:
                elsewhere.hint = f"{elsewhere.hint}; or begin there with --anyway"
                raise
            notes = (str(elsewhere),)
        for words in (*charge, *notes):
            options.remark(words)

    departs_s = math.inf
    if options.depart_at is not None:
        departs_s = vehicle.connection.now() + (options.depart_at - datetime.now(UTC)).total_seconds()
        with options.stages(Stage.READY) as show:
            vehicle.count_down(show, departs_s, Departure.PREPARED_S)
    with options.stages(Stage.READY) as show:
        vehicle.prepare(options.first, show, permit)
        begun = begun_here(vehicle, forecast, options.first)
        vehicle.conformance.begin(_monitor(vehicle, begun, options.first, options.remark))
        if options.depart_at is not None:
            vehicle.count_down(show, departs_s)
    with options.stages(Stage.START) as show:
        vehicle.start(show, departs_s)
    with options.stages(Stage.FLIGHT) as show:
        return vehicle.watch(show)


def _monitor(vehicle: Vehicle, begun: Forecast, first: int, remark: ReportRemark) -> "ConformanceMonitor | None":
    from ipoa_mission.forecast.conformance import ConformanceMonitor

    try:
        if begun.mission_as_read.autopilot is not vehicle.autopilot:
            words = f"it was forecast for {begun.mission_as_read.autopilot}, and the vehicle is {vehicle.autopilot}"
            raise MissionError(words, code="other-autopilot")
        return ConformanceMonitor(begun, first)
    except MissionError as unknown:
        remark(f"the flight is not compared with a forecast: {unknown}")
        return None


def begun_here(vehicle: Vehicle, forecast: Forecast, first: int) -> Forecast:
    at = vehicle.state.position
    there = vehicle.home() if at is None else Geodetic(at.latitude_deg, at.longitude_deg, at.altitude)
    return begun_forecast(forecast, first, there)


def _set_parameters(
    vehicle: Vehicle, differing: Sequence[preflight.OtherValue], show: Progress, remark: ReportRemark
) -> None:
    names = ", ".join(other.name for other in differing)
    for n, other in enumerate(differing):
        show(n / len(differing), names)
        vehicle.set_parameter(other.name, other.wanted)
        remark(f"{other.name} set to {other.wanted:g} (it was {other.has:g})")
    show(1.0, names)


@dataclass
class ContingencyDisplay:
    """Show contingencies by position; append to `reserves` when the battery's share changes."""

    forecast: Forecast
    vehicle: Vehicle
    progress: Progress
    reserves: "list[ReserveNow]"
    contingencies: "ContingenciesNow"
    _shown: tuple[float, str] = (0.0, "")
    _shown_s: float = -math.inf

    def show(self, share: float, words: str) -> None:
        self._shown = (share, words)
        self.progress(share, words)

    def hear(self, message: Message) -> None:
        if not isinstance(message, Position) or message.time_s - self._shown_s < 1.0:
            return
        path = self.vehicle.record().path
        if path and self.vehicle.state.in_air:
            self._shown_s = message.time_s
            place = self.forecast.frame.local(Geodetic(message.latitude_deg, message.longitude_deg, message.altitude))
            time, distance = self.contingencies.time_at(place, path[-1].time_s)
            words = "off its path: not forecast from here"
            if distance <= self.contingencies.off_path:
                words = self.contingencies.words(time)
            now = "; ".join([words, *map(str, self._reserve(time))])
            share, stage = self._shown
            self.progress(share, f"{stage}  now: {now}")

    def _reserve(self, time: float) -> "Iterator[ReserveNow]":
        from ipoa_mission.forecast.contingency.energy_budget import budget_of

        left = self.vehicle.state.battery_left
        budget = budget_of(self.forecast)
        reserve = None if budget is None or left is None else budget.against_plan(left, time)
        if reserve is None:
            return
        if not self.reserves or self.reserves[-1].left != reserve.left:
            self.reserves.append(reserve)
        yield reserve
