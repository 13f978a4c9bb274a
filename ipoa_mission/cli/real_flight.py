"""A flight on a vehicle at the other end of a link, from the first look at it until it stands again."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

from ipoa_mission.checks.start import NotAtStart, begun_at, check_start
from ipoa_mission.cli.flown import flight_as_json
from ipoa_mission.cli.interrupting import left_behind
from ipoa_mission.cli.job import Job
from ipoa_mission.cli.telling import progress_bar
from ipoa_mission.cli.vehicles import put
from ipoa_mission.errors import MissionError
from ipoa_mission.flight.boarding import await_home, expect_slow_landing
from ipoa_mission.link.logbook import FlightRecord
from ipoa_mission.link.set_up import other_values
from ipoa_mission.link.vehicle import Vehicle
from ipoa_mission.timing.estimate import estimate
from ipoa_mission.world.frame import Geodetic


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
    begun = begun_at(job.mission, item - 1)
    return job if item == 1 else replace(job, estimate=estimate(begun, wind=job.wind))


@dataclass
class RealFlight:
    """`first`: index of the item to begin with; `anyway`: what fails a check is said, and done all the same."""

    job: Job
    vehicle: Vehicle
    first: int = 0
    anyway: bool = False
    set_params: bool = False
    remarks: tuple[str, ...] = ()

    def fly(self) -> tuple[tuple[str, ...], FlightRecord]:
        """Upload, make ready, arm, start, watch: what the user should know, and the flight.

        Raises:
            MissionError: it did not come to a flight, or the vehicle was lost; `known` has what is known of it.
        """
        job, vehicle = self.job, self.vehicle
        try:
            vehicle.expect_on_ground()
            with left_behind("nothing was sent"), progress_bar("waiting for a position", is_waiting=True) as show:
                await_home(vehicle, show)
            self.remarks += self._parameters()
            self.remarks += put(job.mission, vehicle, self.anyway)
            with (
                left_behind("the vehicle was not armed"),
                progress_bar("waiting until it is ready", is_waiting=True) as show,
            ):
                vehicle.prepare(self.first, show, self._permit)
            with left_behind("see the hint", hint="look at it"):
                vehicle.start()
            with left_behind("nobody watches, and the vehicle flies on"), progress_bar("flying") as bar:
                return self.remarks, vehicle.watch(bar)
        except MissionError as error:
            state = vehicle.state
            error.known = flight_as_json(job.estimate, vehicle.record())
            error.known |= {"completed": False, "armed": state.armed, "in_air": state.in_air}
            error.known |= {"remarks": list(self.remarks)}
            raise

    def _permit(self, there: Geodetic) -> None:
        scenario = self.job.flight.scenario if self.job.flight else None
        try:
            self.remarks += check_start(self.job.mission, self.first, there, scenario)
        except NotAtStart as elsewhere:
            if not self.anyway:
                elsewhere.hint = f"{elsewhere.hint}; or begin there with --anyway"
                raise
            self.remarks += (str(elsewhere),)

    def _parameters(self) -> tuple[str, ...]:
        """Hold the vehicle's parameters against those that the mission was made for, and set them if that is wished.

        Raises:
            FastLanding: it is not wished, and the vehicle would touch down fast.
        """
        others, missing = other_values(self.vehicle, self.job.mission.parameters)
        remarks = tuple(f"the vehicle has no parameter {name}" for name in missing)
        if not self.set_params:
            if not self.anyway:
                expect_slow_landing(self.job.mission, self.vehicle)
            return remarks + tuple(f"{other}: --set-params writes it" for other in others)
        for other in others:
            self.vehicle.set_parameter(other.name, other.wanted)
        return remarks + tuple(f"{other.name} set to {other.wanted:g} (it was {other.has:g})" for other in others)
