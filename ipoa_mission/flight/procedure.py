"""The one safe way to put a mission on a vehicle, and to fly it: what the command line, the studio and users call."""

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext, suppress
from dataclasses import replace
from enum import StrEnum
from typing import TYPE_CHECKING, TypeAlias

from ipoa_mission.checks.start import NotAtStart, begun_at, check_start
from ipoa_mission.errors import MissionError
from ipoa_mission.flight.preflight import await_home, expect_charge, expect_fit, expect_slow_landing
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.link.dialogue import NoAnswer
from ipoa_mission.link.logbook import FlightRecord
from ipoa_mission.link.messages import MissionType
from ipoa_mission.link.vehicle import Vehicle
from ipoa_mission.link.vehicle_setup import OtherValue, idle_fence, other_values, without_station
from ipoa_mission.mission.items import Mission
from ipoa_mission.progress import Progress, silent
from ipoa_mission.world.frame import Geodetic

if TYPE_CHECKING:
    from ipoa_mission.forecast.conformance import ConformanceMonitor
    from ipoa_mission.scenario import Scenario


class Stage(StrEnum):
    """Where a flight is, from the first look at the vehicle until it stands again."""

    POSITION = "waiting for a position"
    CHECK = "checking the mission against the vehicle"
    UPLOAD = "upload"
    STORED = "the new mission is on the vehicle"
    READY = "waiting until it is ready"
    START = "armed and started"
    FLIGHT = "flying"


#: What is to be shown, and said where it breaks off, while each stage lasts.
Stages: TypeAlias = Callable[[Stage], AbstractContextManager[Progress]]


Remark: TypeAlias = Callable[[str], None]


def unheard(words: str) -> None:
    """Nobody is told."""


def unseen(stage: Stage) -> AbstractContextManager[Progress]:
    """Nothing is shown of any stage."""
    return nullcontext(silent)


def upload_mission(
    vehicle: Vehicle, mission: Mission, *, anyway: bool = False, stages: Stages = unseen
) -> tuple[str, ...]:
    """Check a mission as this very vehicle would meet it, upload it and verify each list.

    Args:
        vehicle: at the other end of a link, as `connect` finds it.
        mission: for this vehicle's autopilot, unless `anyway`.
        anyway: what fails a check is among the remarks, and the mission is sent all the same.
        stages: told of each stage; what it gives shows how far that is.

    Returns:
        Remarks for the user: warnings of the check, parameters that the vehicle has otherwise, a fence that is off.

    Raises:
        Unsafe, FarFromHome, OutsideOwnFence: it would crash, be refused or broken off; nothing was sent.
        MissionError: it was made for another autopilot; or it is not on the vehicle, as `Vehicle.upload` says.

    Example:
        >>> from ipoa_mission import connect, read_mission, upload_mission
        >>> with connect("udpin:127.0.0.1:14550") as vehicle:
        ...     upload_mission(vehicle, read_mission("missions/sitl.plan"))
        ('RTL_RETURN_ALT is 30 on the vehicle, and the mission was made for 70',)
    """
    remarks, others, lacking = _put(vehicle, mission, anyway, stages)
    return (*remarks, *map(str, others), *lacking)


def _put(
    vehicle: Vehicle, mission: Mission, anyway: bool, stages: Stages, is_flown: bool = False
) -> tuple[tuple[str, ...], tuple[OtherValue, ...], tuple[str, ...]]:
    """As `upload_mission`, with the parameters apart that the vehicle has otherwise, or lacks."""
    with stages(Stage.CHECK):
        remarks = expect_fit(vehicle, mission, anyway)
        left = left_lists(vehicle, mission)
        if is_flown and not anyway and MissionType.RALLY in left:
            hint = "clear what it holds (ipoa-mission clear), or fly with --anyway"
            raise MissionError(left[MissionType.RALLY], hint, code="other-rally-points")
    with stages(Stage.UPLOAD) as show:
        vehicle.upload(replace(mission, autopilot=vehicle.autopilot) if anyway else mission, show, checked=False)
    with stages(Stage.STORED):
        idle = idle_fence(vehicle, mission)
        others, missing = other_values(vehicle, mission.parameters)
    lacking = tuple(f"the vehicle has no parameter {name}" for name in missing)
    return (*remarks, *left.values(), *([idle] if idle else [])), others, lacking


def left_lists(vehicle: Vehicle, mission: Mission) -> dict[MissionType, str]:
    """What to say of a fence or rally points that the vehicle holds of another mission, where this one has none."""
    left: dict[MissionType, str] = {}
    for kind, own, words in (
        (MissionType.RALLY, mission.rally, "rally points of another mission: RTL flies to one of them"),
        (MissionType.FENCE, mission.fence, "a fence of another mission: it may end the flight"),
    ):
        with suppress(MissionError):  # a vehicle may know no such list
            if not own and vehicle.download_items(kind):
                left[kind] = f"the vehicle holds {words}, and nobody looked at that"
    return left


def fly_mission(
    vehicle: Vehicle,
    mission: Mission,
    scenario: "Scenario | None" = None,
    *,
    first: int = 0,
    anyway: bool = False,
    set_params: bool = False,
    stages: Stages = unseen,
    remark: Remark = unheard,
) -> FlightRecord:
    """Upload a mission, make the vehicle ready, arm it, start it, and watch it until it stands again.

    Position and progress are compared with the forecast. At the first deviation the vehicle is ordered what
    `vehicle.conformance.on_deviation` says, to hold by default; once it holds, the watching ends.

    Args:
        vehicle: on the ground and disarmed.
        mission: for its autopilot, unless `anyway`.
        scenario: in whose world the way from where the vehicle stands is looked at.
        first: the index in `mission.items` of the item to begin with.
        anyway: what fails a check is told to `remark`, and it is flown all the same.
        set_params: write the parameters that the mission was made for, where the vehicle has others.
        stages: told of each stage; what it gives shows how far that is.
        remark: told what the user should know, as it is found.

    Returns:
        When its items were reached, its path, whether it completed, and its deviations from the forecast.

    Raises:
        NotReady: it is armed already, does not know where it is, or cannot be armed; with its own reasons.
        FastLanding, LowBattery, NotAtStart, Unsafe, FarFromHome, OutsideOwnFence: a check says no, and nothing was
            armed.
        MissionError: as `upload_mission` and `Vehicle.start`, or the vehicle was lost; or it holds rally points of
            another mission, and this one has none.

    Example:
        >>> from ipoa_mission import connect, fly_mission, read_mission, read_scenario
        >>> with connect("udpin:127.0.0.1:14550") as vehicle:
        ...     fly_mission(vehicle, read_mission("missions/sitl.plan"), read_scenario("missions/sitl.toml")).completed
        True
    """
    forecast = Forecast(mission, scenario)
    return fly_forecast(
        vehicle, forecast, first=first, anyway=anyway, set_params=set_params, stages=stages, remark=remark
    )


def fly_forecast(
    vehicle: Vehicle,
    forecast: Forecast,
    *,
    first: int = 0,
    anyway: bool = False,
    set_params: bool = False,
    stages: Stages = unseen,
    remark: Remark = unheard,
) -> FlightRecord:
    """As `fly_mission`, of a mission whose flight is forecast already."""
    own = load_mission(vehicle, forecast, anyway=anyway, set_params=set_params, stages=stages, remark=remark)
    return begin_mission(vehicle, own, first=first, anyway=anyway, stages=stages, remark=remark)


def load_mission(
    vehicle: Vehicle,
    forecast: Forecast,
    *,
    anyway: bool = False,
    set_params: bool = False,
    stages: Stages = unseen,
    remark: Remark = unheard,
) -> Forecast:
    """The first half of `fly_forecast`: all until the mission is on a vehicle that stands and knows where it is.

    Returns:
        The forecast with the vehicle's own values of the parameters that the mission names.
    """
    mission = forecast.given
    vehicle.expect_on_ground()
    with stages(Stage.POSITION) as show:
        await_home(vehicle, show)
    if set_params:
        _set_parameters(vehicle, mission, remark)
    if not anyway:  # also of what was set: a vehicle may lack it, or have lost it again
        expect_slow_landing(vehicle, forecast)
    remarks, others, lacking = _put(vehicle, mission, anyway, stages, is_flown=True)
    with suppress(NoAnswer):  # it does not tell
        vehicle.absence.meanwhile = without_station(vehicle, vehicle.firmware_version())
    for words in (*remarks, *(f"{other}: --set-params writes it" for other in others), *lacking):
        remark(words)
    if not others or mission.autopilot is not vehicle.autopilot:
        return forecast
    own = mission.with_parameters({other.name: other.has for other in others})
    return Forecast(own, forecast.scenario, None if forecast.scenario else forecast.wind)


def begin_mission(
    vehicle: Vehicle,
    forecast: Forecast,
    *,
    first: int = 0,
    anyway: bool = False,
    stages: Stages = unseen,
    remark: Remark = unheard,
) -> FlightRecord:
    """The second half of `fly_forecast`: the vehicle is made ready, armed, started and watched."""

    def permit(there: Geodetic) -> None:
        if not anyway:
            expect_charge(vehicle, forecast, first)
        try:
            told = check_start(forecast, first, there)
        except NotAtStart as elsewhere:
            if not anyway:
                elsewhere.hint = f"{elsewhere.hint}; or begin there with --anyway"
                raise
            told = (str(elsewhere),)
        for words in told:
            remark(words)

    with stages(Stage.READY) as show:
        vehicle.conformance.compare(_monitor(vehicle, forecast, first, remark))
        vehicle.prepare(first, show, permit)
    with stages(Stage.START) as show:
        vehicle.start(show)
    with stages(Stage.FLIGHT) as show:
        return vehicle.watch(show)


def _monitor(vehicle: Vehicle, forecast: Forecast, first: int, remark: Remark) -> "ConformanceMonitor | None":
    """Return what a flight that begins with item `first` is compared with; None, and a remark, where nobody knows."""
    from ipoa_mission.forecast.conformance import ConformanceMonitor

    mission = forecast.given
    try:
        if mission.autopilot is not vehicle.autopilot:
            words = f"it was forecast for {mission.autopilot}, and the vehicle is {vehicle.autopilot}"
            raise MissionError(words, code="other-autopilot")
        if first:
            wind = None if forecast.scenario else forecast.wind
            forecast = Forecast(begun_at(mission, first), forecast.scenario, wind)
        return ConformanceMonitor(forecast)
    except MissionError as unknown:
        remark(f"the flight is not compared with a forecast: {unknown}")
        return None


def _set_parameters(vehicle: Vehicle, mission: Mission, remark: Remark) -> None:
    for other in other_values(vehicle, mission.parameters)[0]:
        vehicle.set_parameter(other.name, other.wanted)
        remark(f"{other.name} set to {other.wanted:g} (it was {other.has:g})")
