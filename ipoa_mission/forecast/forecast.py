from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ipoa_mission.autopilot.failsafe import TIMED, Contingency, FlightStage
from ipoa_mission.autopilot.known_parameters import expect_known
from ipoa_mission.autopilot.parameters import NO_PARAMETERS, Parameters
from ipoa_mission.autopilot.version import Version
from ipoa_mission.errors import MissionError, NotModeled
from ipoa_mission.forecast.deviation.law import DeviationLaw, law_of
from ipoa_mission.forecast.itinerary.flown_legs import Leg, flown_legs, join, trace_returns
from ipoa_mission.forecast.itinerary.itinerary import Itinerary, Unknown, find_unknown, itinerary, past_jumps
from ipoa_mission.forecast.timing.estimate import Estimate, times_of
from ipoa_mission.forecast.timing.flight_model import FlightModel, Prediction
from ipoa_mission.forecast.timing.track import Track
from ipoa_mission.geodesy import LocalFrame
from ipoa_mission.geometry import Points, Vector
from ipoa_mission.ground import Ground
from ipoa_mission.mission.item_words import name_items
from ipoa_mission.mission.items import Mission
from ipoa_mission.mission.landing_ground import known_ground, landing_over
from ipoa_mission.mission.positions import refuse_unsound
from ipoa_mission.wind import CALM, Wind

if TYPE_CHECKING:
    from ipoa_mission.forecast.deviation.clearance_guarantee import ClearanceGuarantee
    from ipoa_mission.forecast.flight_energy import Consumption
    from ipoa_mission.planning.proof import Proof
    from ipoa_mission.scenario import Scenario

Made = TypeVar("Made")


class Forecast:
    """One mission's flight, in a scenario's world if given.

    Args:
        mission: the mission to fly.
        scenario: its world.
        wind: replaces the scenario's wind.
        left_out: items without legs to or from them.

    Attributes:
        mission_as_read: the mission as passed in, with the scenario's firmware version where it names none.

    Example:
        >>> from ipoa_mission import Forecast, read_mission, read_scenario
        >>> forecast = Forecast(read_mission("missions/sitl.plan"), read_scenario("missions/sitl.toml"))
        >>> forecast.proof.is_proved, len(forecast.estimate.items) == len(forecast.mission.items)
        (True, True)
    """

    def __init__(
        self,
        mission: Mission,
        scenario: "Scenario | None" = None,
        wind: Wind | None = None,
        left_out: frozenset[int] = frozenset(),
    ) -> None:
        self.left_out = left_out
        self._made: dict[Any, Any] = {}
        self.wind = wind or (CALM if scenario is None else scenario.wind.air())
        if scenario is not None:
            scenario = scenario.in_wind(wind).flown_by(mission.autopilot)
            vehicle = scenario.vehicle
            version = mission.firmware_version or vehicle.version
            unmeasured = mission.unmeasured_version or vehicle.unmeasured_version
            mission = replace(mission, firmware_version=version, unmeasured_version=unmeasured)
        self.scenario = scenario
        self.mission_as_read = mission

    @cached_property
    def mission(self) -> Mission:
        """Return the mission with the scenario's parameters, and its learned values, where it sets none.

        Raises:
            BadInput: the mission is of another place than the scenario.
        """
        if self.scenario is None:
            return self.mission_as_read
        vehicle = self.scenario.vehicle
        self.scenario.expect_here(self.mission_as_read.home)
        flown = self.mission_as_read.assuming(vehicle.autopilot_parameters())
        return landing_over(replace(flown, vehicle=flown.vehicle or vehicle.learned), self.ground)

    def on(self, version: Version | None) -> "Forecast":
        if version is None or version == self.mission_as_read.firmware_version:
            return self
        mission = replace(self.mission_as_read, firmware_version=version)
        return Forecast(mission, self.scenario, self.wind, self.left_out)

    def with_mission(self, mission: Mission, left_out: frozenset[int] = frozenset()) -> "Forecast":
        """Return the forecast of another `mission` in the same wind, without the legs of `left_out` either."""
        return Forecast(mission, self.scenario, None if self.scenario else self.wind, self.left_out | left_out)

    def cached(self, make: "Callable[[Forecast], Made]", by: "Callable[[Forecast], Made] | None" = None) -> "Made":
        """Return `make` of this forecast, computed once; `by` is a faster way."""
        if make not in self._made:
            self._made[make] = (by or make)(self)
        made: Made = self._made[make]
        return made

    def drop(self, make: "Callable[[Forecast], Any]") -> None:
        """Drop the cached result of `make`, and large parts of the guarantee."""
        self._made.pop(make, None)
        if "guarantee" in self.__dict__:
            self.guarantee.flight.drop_pieces()

    @property
    def world(self) -> "Scenario":
        if self.scenario is None:
            raise MissionError("expected a forecast of a mission in a scenario", code="scenario-missing")
        return self.scenario

    @cached_property
    def frame(self) -> LocalFrame:
        """Return the scenario's frame; `itinerary`, `ground`, `predicted` are in the mission's."""
        return self.mission.frame if self.scenario is None else self.scenario.frame

    def placed(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return points (..., 3) of the mission's frame in `frame`."""
        return self.frame.moved(points, self.mission_as_read.frame)

    @property
    def home(self) -> Vector:
        return self.placed(np.zeros(3))

    @property
    def ground_at_home(self) -> float:
        """Above the mission's home [m]."""
        return float(self.world.airspace.ground(self.home[None, :])[0] - self.home[2])

    @cached_property
    def ground(self) -> Ground:
        """As the vehicle measures it; level where unknown."""
        if self.scenario is None:
            return known_ground(self.mission)
        return self.scenario.ground_from(self.mission_as_read.frame)

    @cached_property
    def legs(self) -> tuple[Leg, ...]:
        over = self.ground if self.scenario is None else self.scenario.airspace.ground
        legs = flown_legs(self.mission, self.frame, None if over.is_flat else over)
        after = {min((leg.seq for leg in legs if leg.seq > seq), default=seq) for seq in self.left_out}
        return tuple(leg for leg in legs if leg.seq not in after | self.left_out)

    @property
    def cruise(self) -> list[Leg]:
        return [leg for leg in self.legs if leg.stage is FlightStage.ROUTE and not leg.alternative]

    @property
    def ways_home(self) -> list[Leg]:
        return [leg for leg in self.legs if leg.stage is FlightStage.RETURN]

    def returns_from(self, places: Points) -> NDArray[np.float64]:
        """Return paths of returns, (goals, n, 3, 3) [m]."""
        return trace_returns(self.mission, self.frame, places)

    @cached_property
    def itinerary(self) -> Itinerary:
        return itinerary(self.mission, self.ground, self.ground_at_home if self.home.any() else 0.0)

    @cached_property
    def unknown(self) -> tuple[Unknown, ...]:
        return tuple(find_unknown(self.mission_as_read))

    def predicted(self, noise_free: bool) -> Prediction:
        """Predict times and places, `noise_free` or with the mean of sensor noise.

        Raises:
            BadInput: the mission has no end, or a parameter is invalid.
            MissionError: the vehicle makes no progress, flies items in another order, or has no model.
        """
        unknown = next(past_jumps(self.mission_as_read), None)
        if unknown is not None:
            raise _refusal(unknown, "time")
        if self.mission.other_vehicle:
            other = self.mission.other_vehicle
            raise NotModeled(f"the mission is for {other}, and only multicopters have a time model")
        model = self.mission.autopilot.part(FlightModel)
        if noise_free and model.is_always_noise_free:
            return self.expected  # a long flight is large
        return model.predicted(self.itinerary, self._air, noise_free)

    def predicted_with(self, contingency: Contingency, time: float) -> Prediction:
        """Predict the flight until `contingency` is ordered at `time` [s], then that until it disarms.

        Raises:
            MissionError: as `predicted`; or it is not `TIMED`.
        """
        if contingency not in TIMED:
            raise NotModeled(f"the duration of {contingency} is not modeled")
        model = self.mission.autopilot.part(FlightModel)
        return model.predict_contingency(self.itinerary, self._air, contingency, time)

    @property
    def _air(self) -> Wind:
        if self.scenario is None:
            return self.wind
        lower = self.scenario.frame.home.altitude - self.mission.home.altitude
        levels = tuple(level._replace(height=level.height + lower) for level in self.wind.levels)
        return replace(self.wind, levels=levels, base=self.wind.base + lower if self.wind.exponent else 0.0)

    @property
    def deviation_law(self) -> DeviationLaw:
        """Return the law in the strongest wind."""
        return law_of(self.mission.autopilot, self.wind.strongest)

    @cached_property
    def estimate(self) -> Estimate:
        times = times_of(self.itinerary, self.expected)
        unknown = (f"item {item.seq}: {item.why}: the time after it is unknown" for item in self.unknown)
        return replace(times, track=self.placed_track(times.track), remarks=(*times.remarks, *unknown))

    def placed_track(self, track: Track) -> Track:
        return replace(track, points=self.placed(track.points))

    @cached_property
    def expected(self) -> Prediction:
        return self.predicted(noise_free=False)

    @cached_property
    def energy(self) -> "Consumption | None":
        used = self.energy_of(self.estimate.track)
        return None if used is None else used.lasting(self.estimate.low_s, self.estimate.high_s)

    def energy_of(self, track: Track) -> "Consumption | None":
        if (self.scenario is None and self.mission.vehicle is None) or not np.diff(track.times).any():
            return None
        from ipoa_mission.forecast.flight_energy import flight_energy

        return flight_energy(self.scenario, track, self.mission.vehicle, self.wind)

    @cached_property
    def guarantee(self) -> "ClearanceGuarantee":
        """Return the kept limits; raises as `predicted`, and if the path is unknown."""
        from ipoa_mission.forecast.deviation.clearance_guarantee import PredictedFlight, clearance_guarantee_of
        from ipoa_mission.forecast.deviation.kept_limits import clearance_task

        self.expect_known_path()
        task = clearance_task(self.world, self.mission.autopilot)
        predicted = self.predicted(noise_free=True)
        model = self.mission.autopilot.part(FlightModel)
        excess = None if task.chance is None else model.excess_deviation(self.itinerary, self._air, predicted)
        track = self.placed_track(predicted.track.local())
        return clearance_guarantee_of(PredictedFlight(self.itinerary, predicted, track, task, excess))

    @property
    def over_uneven_terrain(self) -> tuple[int, ...]:
        """Return the items whose height over terrain is predicted as height over home, though it is not level."""
        return () if self.ground.is_flat else self.itinerary.over_terrain

    def expect_known_path(self) -> None:
        if self.unknown:
            raise _refusal(self.unknown[0], "clearance")
        if self.over_uneven_terrain:
            words = "its height over uneven terrain is not modeled; the clearance of flights is unknown"
            raise NotModeled(words, place=name_items(self.over_uneven_terrain))

    @property
    def guarantee_if_known(self) -> "ClearanceGuarantee | None":
        try:
            return self.guarantee if self.itinerary.visits else None
        except MissionError:
            return None

    @property
    def proof_if_known(self) -> "Proof | None":
        return None if self.unknown or not self.cruise else self.proof

    @cached_property
    def proof(self) -> "Proof":
        from ipoa_mission.planning.proof import prove

        points, chord_error = join(self.cruise)
        return prove(points, self.world, chord_error)


def _refusal(at: Unknown, quantity: str) -> MissionError:
    return MissionError(f"{at.why}; the {quantity} is unknown", at.hint, code=at.code, place=f"item {at.seq}")


def estimate(mission: Mission, parameters: Parameters = NO_PARAMETERS, wind: Wind = CALM) -> Estimate:
    """Predict when each item of the mission will be done, by the model of `mission.autopilot`.

    Args:
        mission: the mission to fly.
        parameters: replace those of the mission, and these the autopilot's defaults.
        wind: in which it is flown.

    Returns:
        The total time and that of each item.

    Raises:
        BadInput: the mission has no end, or a parameter is invalid or unknown to this autopilot.
        MissionError: the vehicle makes no progress, as in a wind stronger than it can fly; or it is no multicopter.

    Example:
        >>> from ipoa_mission import Wind, estimate, read_mission
        >>> mission = read_mission("missions/sitl.plan")
        >>> calm, slower = estimate(mission), estimate(mission, {"MPC_XY_VEL_MAX": 4.0}, Wind(4.0, from_deg=270.0))
        >>> slower.total_s > calm.total_s
        True
    """
    expect_known(parameters, mission.autopilot)
    refuse_unsound(mission)
    return Forecast(mission.with_parameters(parameters), wind=wind).estimate
