"""A flight on a vehicle at the other end of a link, from the first look at it until it stands again."""

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

from ipoa_mission.checks.start import begun_at
from ipoa_mission.cli.flown import flight_as_json
from ipoa_mission.cli.job import Job
from ipoa_mission.cli.vehicles import stages_shown
from ipoa_mission.errors import MissionError
from ipoa_mission.flight.procedure import fly_forecast
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.link.logbook import FlightRecord
from ipoa_mission.link.vehicle import Vehicle

log = logging.getLogger(__name__)


@contextmanager
def no_flight_yet() -> Iterator[None]:
    """What fails in here tells machines that no flight was flown, and of the vehicle what is known, if anything."""
    try:
        yield
    except MissionError as error:
        error.known = {"completed": False, "armed": None, "in_air": None} | error.known
        raise


def begun_with(job: Job, item: int) -> Job:
    """The job as it is estimated where it begins with another item than the first, as a file numbers them.

    Raises:
        BadInput: there is no such item, or it has no place to fly to.
    """
    begun = Forecast(begun_at(job.mission, item - 1), wind=job.forecast.wind)
    if item == 1:
        return job
    log.info("%s: from item %d on estimated %.1f s", job.name, item, begun.estimate.total_s)
    return replace(job, begun=begun)


def fly_there(
    job: Job, vehicle: Vehicle, first: int, anyway: bool, set_params: bool
) -> tuple[tuple[str, ...], FlightRecord]:
    """Upload, make ready, arm, start, watch: what the user should know, and the flight.

    `first`: index of the item to begin with; `anyway`: what fails a check is said, and done all the same.

    Raises:
        MissionError: it did not come to a flight, or the vehicle was lost; `known` has what is known of it.
    """
    remarks: list[str] = []
    try:
        record = fly_forecast(
            vehicle,
            job.forecast,
            first=first,
            anyway=anyway,
            set_params=set_params,
            stages=stages_shown,
            remark=remarks.append,
        )
    except MissionError as error:
        state = vehicle.state
        error.known = flight_as_json(job.estimate, vehicle.record())
        error.known |= {"completed": False, "armed": state.armed, "in_air": state.in_air, "remarks": remarks}
        raise
    return tuple(remarks), record
