import logging
import math
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from functools import partial

from ipoa_mission.checks.start import begun_at
from ipoa_mission.cli.flown_output import flight_as_json
from ipoa_mission.cli.interrupting import reporting_interrupt
from ipoa_mission.cli.mission_source import Job
from ipoa_mission.cli.output import print_json
from ipoa_mission.cli.vehicles import stages_shown
from ipoa_mission.errors import MissionError
from ipoa_mission.flight.procedure import ProcedureOptions, Stage, begin_mission, load_mission
from ipoa_mission.forecast.conformance import Deviation
from ipoa_mission.forecast.contingency.contingencies_now import ContingenciesNow
from ipoa_mission.forecast.contingency.energy_budget import ReserveNow, budget_of
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.link.logbook import FlightRecord
from ipoa_mission.link.messages import Message
from ipoa_mission.link.telemetry import Position
from ipoa_mission.link.vehicle import Vehicle
from ipoa_mission.progress import Progress
from ipoa_mission.world.frame import Geodetic

FORECAST_INTERVAL_S = 1.0

log = logging.getLogger(__name__)


@contextmanager
def no_flight_yet() -> Iterator[None]:
    """Report errors as no flight, with the vehicle's known data for JSON."""
    try:
        yield
    except MissionError as error:
        error.known = {"completed": False, "armed": None, "in_air": None} | error.known
        raise


def print_deviation(deviation: Deviation) -> None:
    print_json({"event": "deviation"} | deviation.as_json(), indent=None)


def begun_with(job: Job, item: int) -> Job:
    """Return the job from another item than the first. Raises BadInput."""
    begun = Forecast(begun_at(job.mission, item - 1), wind=job.forecast.wind)
    if item == 1:
        return job
    log.info("%s: from item %d on estimated %.1f s", job.name, item, begun.estimate.total_s)
    return replace(job, begun=begun)


def fly_there(
    job: Job, vehicle: Vehicle, first: int, anyway: bool, set_params: bool
) -> tuple[tuple[str, ...], FlightRecord]:
    """Upload, arm, start, watch; `anyway`: continue after failed checks. Raises MissionError with `known` data."""
    remarks, known = list[str](), list[ContingenciesNow]()
    stages = partial(_with_endings, job.forecast, vehicle, job.reserves, known)
    options = ProcedureOptions(first, anyway, job.ignore, set_params, stages, remarks.append)
    try:
        with reporting_interrupt(""):  # between two stages
            record = begin_mission(vehicle, load_mission(vehicle, job.forecast, options), options)
    except MissionError as error:
        state = vehicle.state
        error.known = flight_as_json(job.estimate, vehicle.record(), job.reserves)
        error.known |= {"completed": False, "armed": state.armed, "in_air": state.in_air, "remarks": remarks}
        raise
    return tuple(remarks), record


@contextmanager
def _with_endings(
    forecast: Forecast, vehicle: Vehicle, reserves: list[ReserveNow], known: list[ContingenciesNow], stage: Stage
) -> Iterator[Progress]:
    """Yield stages with this second's contingencies, computed before arming: in the air links must be served."""
    with stages_shown(stage) as show:
        told = None
        if stage is Stage.READY and forecast.scenario is not None:
            with suppress(MissionError):
                known.append(ContingenciesNow(forecast))
        if stage is Stage.FLIGHT and known:
            told = ContingencyDisplay(forecast, vehicle, show, reserves, known[0])
            vehicle.overhearing = told.hear
        yield show if told is None else told.show


class ContingencyDisplay:
    """Show contingencies by position; append to `reserves` when the battery's share changes."""

    def __init__(
        self,
        forecast: Forecast,
        vehicle: Vehicle,
        show: Progress,
        reserves: list[ReserveNow],
        endings: ContingenciesNow,
    ) -> None:
        self._now, self._frame, self._vehicle, self._show = endings, forecast.frame, vehicle, show
        self._done, self._words, self._told_s = 0.0, "", -math.inf
        self._budget, self._reserves = budget_of(forecast), reserves

    def show(self, share: float, words: str) -> None:
        self._done, self._words = share, words
        self._show(share, words)

    def hear(self, message: Message) -> None:
        if not isinstance(message, Position) or message.time_s - self._told_s < FORECAST_INTERVAL_S:
            return
        path = self._vehicle.record().path
        if path and self._vehicle.state.in_air:
            self._told_s = message.time_s
            place = self._frame.local(Geodetic(message.latitude_deg, message.longitude_deg, message.altitude))
            time, _ = self._now.time_at(place, path[-1].time_s)
            words = [self._now.words(time), *map(str, self._reserve(time))]
            self._show(self._done, f"{self._words}  now: {'; '.join(words)}")

    def _reserve(self, time: float) -> Iterator[ReserveNow]:
        left = self._vehicle.state.battery_left
        if self._budget is None or left is None:
            return
        if (now := self._budget.against_plan(left, time)) is not None:
            if not self._reserves or self._reserves[-1].left != now.left:
                self._reserves.append(now)
            yield now
