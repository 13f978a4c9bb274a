"""Fly a mission on the vehicle of a link, and show its contingencies in flight."""

import logging
import math
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from ipoa_mission.checks.start import begun_at
from ipoa_mission.cli.flight_output import flight_as_json
from ipoa_mission.cli.interrupting import note_flown, reporting_interrupt, showing_stage
from ipoa_mission.cli.linking import connect_to, states_firmware
from ipoa_mission.cli.mission_source import FlownJob, Job, landing_remarks, read_job
from ipoa_mission.cli.output import print_json
from ipoa_mission.cli.planners import FlyOptions
from ipoa_mission.errors import MissionError
from ipoa_mission.flight.procedure import ProcedureOptions, Stage, begin_mission, load_mission
from ipoa_mission.forecast.contingency.contingencies_now import ContingenciesNow
from ipoa_mission.forecast.contingency.energy_budget import ReserveNow, budget_of
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link.messages import Message
from ipoa_mission.link.telemetry import Position
from ipoa_mission.link.vehicle import Vehicle
from ipoa_mission.mission.flight_record import FlightRecord
from ipoa_mission.progress import Progress

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class RealVehicle:
    source: Path
    asked: FlyOptions

    def fly(self, job: Job, frames_log: Path) -> FlownJob:
        """Connect, upload, arm, start, watch; errors have `known` data for JSON."""
        asked, on_vehicle, on_link = self.asked, self.asked.on_vehicle, self.asked.on_link
        _begun_at_item(job, on_vehicle.begin)  # an unknown item is an error before connecting
        try:
            with connect_to(on_vehicle.link or "", on_link, frames_log) as vehicle:
                if not states_firmware(self.source, asked.flown_by.autopilot):
                    job = read_job(self.source, asked.flown_by, vehicle.autopilot, job.ignore)
                vehicle.conformance.on_deviation = on_vehicle.on_deviation
                if asked.files.as_json:
                    vehicle.conformance.report = lambda deviation: print_json(
                        {"event": "deviation"} | deviation.as_json(), indent=None
                    )
                on_link.system = vehicle.system  # the next flight is this vehicle's, whatever else is heard
                job = _begun_at_item(
                    replace(job, forecast=job.forecast.on(vehicle.firmware_version())), on_vehicle.begin
                )
                remarks, record = self._fly_on(vehicle, job)
                note_flown(job.name, record.armed)
        except MissionError as error:
            error.known = {"completed": False, "armed": None, "in_air": None} | error.known
            raise
        left = ("the vehicle is no longer watched", vehicle.link_loss.meanwhile)
        unwatched = ["; ".join(filter(None, left))] if record.armed else []
        return FlownJob(job, (*remarks, *unwatched, *landing_remarks(job, record)), record)

    def _fly_on(self, vehicle: Vehicle, job: Job) -> tuple[list[str], FlightRecord]:
        remarks, contingencies = list[str](), list[ContingenciesNow]()
        on_vehicle, anyway = self.asked.on_vehicle, self.asked.on_link.anyway
        first, set_params = on_vehicle.begin - 1, on_vehicle.set_params
        again = f"{on_vehicle.link} --system {vehicle.system}"
        stages = partial(_showing_contingencies, job, vehicle, contingencies, again)
        options = ProcedureOptions(first, anyway, job.ignore, set_params, stages, remarks.append)
        try:
            with reporting_interrupt(""):  # between two stages
                record = begin_mission(vehicle, load_mission(vehicle, job.forecast, options), options)
        except MissionError as error:
            state = vehicle.state
            error.known = flight_as_json(job.estimate, vehicle.record(), job.reserves)
            error.known |= {"completed": False, "armed": state.armed, "in_air": state.in_air, "remarks": remarks}
            raise
        return remarks, record


def _begun_at_item(job: Job, item: int) -> Job:
    begun = Forecast(begun_at(job.mission, item - 1), wind=job.forecast.wind)
    if item == 1:
        return job
    log.info("%s: from item %d on estimated %.1f s", job.name, item, begun.estimate.total_s)
    return replace(job, begun=begun)


@contextmanager
def _showing_contingencies(
    job: Job, vehicle: Vehicle, contingencies: list[ContingenciesNow], link: str, stage: Stage
) -> Iterator[Progress]:
    """Yield stages with this second's contingencies, computed before arming: in the air links must be served."""
    with showing_stage(stage, link) as show:
        if stage is Stage.READY and job.forecast.scenario is not None:
            with suppress(MissionError):
                contingencies.append(ContingenciesNow(job.forecast))
        if stage is Stage.FLIGHT and contingencies:
            display = ContingencyDisplay(job.forecast, vehicle, show, job.reserves, contingencies[0])
            vehicle.overhearing, show = display.hear, display.show
        yield show


class ContingencyDisplay:
    """Show contingencies by position; append to `reserves` when the battery's share changes."""

    def __init__(
        self,
        forecast: Forecast,
        vehicle: Vehicle,
        show: Progress,
        reserves: list[ReserveNow],
        contingencies: ContingenciesNow,
    ) -> None:
        self._now, self._frame, self._vehicle, self._show = contingencies, forecast.frame, vehicle, show
        self._done, self._words, self._shown_s = 0.0, "", -math.inf
        self._budget, self._reserves = budget_of(forecast), reserves

    def show(self, share: float, words: str) -> None:
        self._done, self._words = share, words
        self._show(share, words)

    def hear(self, message: Message) -> None:
        interval_s = 1.0
        if not isinstance(message, Position) or message.time_s - self._shown_s < interval_s:
            return
        path = self._vehicle.record().path
        if path and self._vehicle.state.in_air:
            self._shown_s = message.time_s
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
