"""A third vehicle in one file: it flies straight at one speed, within half a meter of its path."""

import json
import math
import pickle
from collections.abc import Mapping
from dataclasses import replace
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any, ClassVar, cast

import numpy as np
import pytest

from ipoa_mission.autopilot import autopilot as register
from ipoa_mission.autopilot.autopilot import QUADROTOR, Autopilot, registered
from ipoa_mission.autopilot.commands import FLOWN_TO, Command
from ipoa_mission.autopilot.failsafe import OwnFence
from ipoa_mission.autopilot.firmware_tables import Firmware, FirmwareTables, Refusals, Refused
from ipoa_mission.autopilot.guidance_profile import GuidanceProfile, Modes, ProtocolProfile
from ipoa_mission.autopilot.parameters import Parameter, Parameters, ParameterTable
from ipoa_mission.autopilot.returning import ReturnBy, ReturnOrder, ReturnRoute, SinkingBrake, SlowedBy, SlowStretch
from ipoa_mission.autopilot.version import Version
from ipoa_mission.forecast.deviation.law import DeviationLaw, Quantiles
from ipoa_mission.forecast.itinerary.itinerary import Itinerary
from ipoa_mission.forecast.timing.flight_model import FlightModel, Kinematics, Prediction
from ipoa_mission.forecast.timing.track import Track
from ipoa_mission.geometry import Place, Vector
from ipoa_mission.mission.items import Item
from ipoa_mission.mission.program import Program
from ipoa_mission.simulator.mock_profile import MockProfile
from ipoa_mission.simulator.situation import STEP_S, FlightMode, Situation
from ipoa_mission.wind import Wind
from tests.cli.conftest import Outcome, Run
from tests.refused import refuses

SPEED, RADIUS = 4.0, 0.05  # [m/s], [m]
MODES = Modes(2, 2, 1, 3, frozenset({3}), 4, {1: "WAIT", 2: "GO", 3: "HOME", 4: "DOWN"})
ALL_SEVEN = "......."
TAKEN = {int(c): ALL_SEVEN for c in (*FLOWN_TO, Command.NAV_RETURN_TO_LAUNCH, Command.DO_CHANGE_SPEED)}
FIRMWARE = Firmware(
    autopilot="toy",
    name="Toy",
    home_is_item_0=False,
    keeps_autocontinue=True,
    fence={},
    rally={},
    max_items=100,
    max_fence_items=0,
    max_rally_points=0,
    highest_altitude=math.inf,
    version=Version(1, 0),
    frames=frozenset({0, 2, 3, 5, 6}),
    placed=TAKEN,
    plain=TAKEN,
)


def way(program: Program, index: int, here: Place, ground: float) -> list[Place]:
    item, (east, north, up) = program.items[index], here
    match item.command:
        case Command.NAV_TAKEOFF:
            return [(east, north, program.place(index, here)[2])]
        case Command.NAV_LAND:
            there = program.place(index, here)
            return [(there[0], there[1], up), (there[0], there[1], ground)]
        case Command.NAV_RETURN_TO_LAUNCH:
            return [(0.0, 0.0, up), (0.0, 0.0, ground)]
        case command if command in FLOWN_TO:
            return [program.place(index, here)]
    return []


class Model(FlightModel):
    scatter = (0.1, 0.01, 0.1)
    takeoff_scatter_s = 0.1
    simulated_lag = 0.05

    def predicted(self, itinerary: Itinerary, wind: Wind, noise_free: bool) -> Prediction:
        here, clock, speed = (0.0, 0.0, 0.0), 0.0, SPEED
        times, points, done = [0.0], [here], []
        for n, visit in enumerate(itinerary.visits):
            if visit.item.command == Command.DO_CHANGE_SPEED:
                speed = visit.item.params[1]
            for place in way(itinerary.program, n, here, 0.0):
                clock += math.dist(here, place) / speed
                here = place
                times.append(clock)
                points.append(here)
            done.append(clock)
        clear = np.concatenate([[True], np.diff(times) > 0.0])
        flown = Track(np.array(times)[clear], np.array(points)[clear], np.full(int(clear.sum()), speed))
        ends = np.array(done)
        return Prediction(ends, ends - 0.5, ends + 0.5, ("",) * len(ends), flown)

    def kinematics(self, parameters: Parameters, speed: float | None = None) -> Kinematics:
        return Kinematics(speed or SPEED, SPEED, SPEED, 100.0)


class StraightController:
    def __init__(self, now: Situation, *_: object) -> None:
        self.now = now
        self.ahead: list[Place] = []
        self.speed, self.goes = SPEED, False

    def enter(self) -> None:
        self.goes = self.now.mode is not FlightMode.HOLD
        if self.now.mode is FlightMode.MISSION:
            self._begin(self.now.current - 1)

    def follow_new_mission(self, before: tuple[Item, ...]) -> None:
        self._begin(self.now.current - 1)

    def climb(self, height: float) -> None:
        self.ahead = [(*self.now.place[:2], height)]

    def step(self) -> None:
        if not (self.now.armed and self.goes):
            return
        left = self.speed * STEP_S
        while self.ahead and left > 0.0:
            far = math.dist(self.now.place, self.ahead[0])
            share = min(1.0, left / far) if far > 0.0 else 1.0
            (x, y, z), (to_x, to_y, to_z) = self.now.place, self.ahead[0]
            self.now.place = x + share * (to_x - x), y + share * (to_y - y), z + share * (to_z - z)
            left -= far
            if share == 1.0:
                self.ahead.pop(0)
        self.now.landed = self.now.on_ground = self.now.place[2] <= 0.0 and self.now.landed
        if self.now.place[2] > 0.0:
            self.now.landed = self.now.on_ground = False
        if not self.ahead:
            self._arrived()

    def _begin(self, behind: int) -> None:
        def quicker(item: Item) -> None:
            self.speed = item.params[1]

        item = self.now.come_to(behind, quicker)
        if item is not None:
            self.ahead = way(self.now.program, self.now.current, self.now.place, 0.0)

    def _arrived(self) -> None:
        item = self.now.program.items[self.now.current]
        if item.command in (Command.NAV_LAND, Command.NAV_RETURN_TO_LAUNCH):
            self.now.on_ground = True
            self.goes = False
            self.now.end_on_ground()
            return
        self.now.done(self.now.current)
        self._begin(self.now.current)


def _spread(most: float) -> Quantiles:
    return Quantiles((0.0, most / 2, most), (1.0, 0.1, 0.001))


LAW = DeviationLaw(
    lateral=_spread(0.4),
    down=_spread(0.3),
    up=_spread(0.3),
    lowest=_spread(0.3),
    highest=_spread(0.3),
    farthest=None,
    doubling_acceleration=10.0,
    after_cruise_factor=1.0,
    decorrelation_s=2.0,
    height_decorrelation_s=5.0,
    growth=(0.0, 0.0, 0.0),
    source="made up",
    strongest=3.0,
)


class Toy(Autopilot):
    name, model = "toy", "Toycopter"
    mav_autopilot, mav_types = 9, frozenset({QUADROTOR})
    measured = (Version(1, 0),)
    modes = MODES
    parameter_table = ParameterTable(
        affecting=(
            Parameter("TOY_SPEED", SPEED, meaning="cruise speed"),
            Parameter("TOY_UP", SPEED, meaning="climb speed"),
            Parameter("TOY_DOWN", SPEED, meaning="descent speed"),
            Parameter("TOY_RTL", 10.0, meaning="return height"),
            Parameter("TOY_WAIT", 0.0),
        ),
        further=(Parameter("TOY_ID", 1.0), Parameter("TOY_FENCE", 0.0, meaning="fence switch")),
        set_up=(),
        surely_there=(("TOY_ID",),),
    )
    tables = FirmwareTables(FIRMWARE, Path(__file__).with_name("no_tables.json"))
    guidance = GuidanceProfile(passes_before=frozenset())
    protocol_profile = ProtocolProfile(starts_by_command=True)
    refusals = Refusals(
        lambda firmware, command, *_: None if firmware.takes(command) else Refused("UNSUPPORTED"),
        lambda *_: Refused("UNSUPPORTED"),
        lambda *_: Refused("UNSUPPORTED"),
    )
    slowed_by = SlowedBy((), 0.0, ())
    own_fence_by = ("TOY_FENCE",)
    parts: ClassVar[Mapping[str, Any]] = {"FlightModel": Model(), "DeviationLaw": LAW}

    def braking_distance(self, parameters: Parameters, speed: Vector, accel: Vector) -> Vector:
        return 0.0 * speed

    def sinking_brake(self, parameters: Parameters) -> SinkingBrake:
        return SinkingBrake(SPEED, SPEED, 0.0, 0.0, 0.0)

    def slow_stretch(self, parameters: Parameters) -> SlowStretch | None:
        return None

    def own_fence(self, parameters: Parameters) -> OwnFence | None:
        return None

    def return_route(self, parameters: Parameters, order: ReturnOrder) -> ReturnRoute:
        return ReturnRoute(ReturnBy.DIRECT)

    def return_height(self, parameters: Parameters, height: float, distance: float, goal_up: float = 0.0) -> float:
        return height


SCENARIO = """
name = "hop"
safety_distance = 1.5
[home]
latitude_deg = 47.397742
longitude_deg = 8.545594
altitude_amsl = 488.0
[vehicle]
autopilot = "toy"
cruise_speed = 5.0
radius = 0.3
[start]
east = 0.0
north = 0.0
up = 12.0
[goal]
east = 60.0
north = 0.0
up = 12.0
[bounds]
east = [-20.0, 80.0]
north = [-40.0, 40.0]
up = [0.0, 40.0]
[[obstacles]]
kind = "cylinder"
east = 30.0
north = 1.0
radius = 5.0
height = 30.0
[optimizer]
population = 8
iterations = 8
"""


@pytest.fixture
def toy(monkeypatch: pytest.MonkeyPatch) -> Autopilot:
    vehicle = Toy()
    spoken = replace(  # speaks as PX4, with its own numbers
        Autopilot.PX4.part(MockProfile),
        autopilot=vehicle,
        controller=StraightController,
        modes={FlightMode.HOLD: 1, FlightMode.MISSION: 2, FlightMode.RETURN: 3, FlightMode.LAND: 4},
        first_mode=1,
        placed_modes=frozenset({2, 3, 4}),
        armable_modes=frozenset({1, 2}),
        disarm_delay="TOY_WAIT",
    )
    monkeypatch.setattr(Toy, "parts", {**Toy.parts, "MockProfile": spoken})
    monkeypatch.setitem(register._registered(), vehicle.name, vehicle)
    return vehicle


def parsed(outcome: Outcome) -> dict[str, Any]:
    assert outcome.code == 0, outcome
    return cast(dict[str, Any], json.loads(outcome.out))


def test_a_third_vehicle_goes_the_whole_way(toy: Autopilot, tmp_path: Path, run: Run) -> None:
    (tmp_path / "hop.toml").write_text(SCENARIO, encoding="utf-8")
    assert pickle.loads(pickle.dumps(toy)) is toy
    parsed(run("plan hop.toml --json"))
    plan = json.loads((tmp_path / "hop.plan").read_text(encoding="utf-8"))
    assert plan["mission"]["firmwareType"] == toy.mav_autopilot
    assert parsed(run("check hop.plan --scenario hop.toml --json"))["firmware"]["autopilot"] == toy.name
    estimated = parsed(run("estimate hop.plan --json"))
    assert run("show hop.plan").code == 0
    assert run("export hop.plan hop.kml").code == 0
    flown = parsed(run("fly hop.plan --json"))
    assert flown["completed"]
    assert flown["flown_s"] == pytest.approx(estimated["total_s"], abs=1.0)
    assert len(flown["items"]) == len(estimated["items"])


def test_third_vehicle_is_gone_again() -> None:
    assert "toy" not in map(str, registered())


def test_two_vehicles_of_one_name_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    entries = [
        EntryPoint("px4", "ipoa_mission.vehicles.px4_multicopter.vehicle:PX4_MULTICOPTER", "x"),
        EntryPoint("px4", "ipoa_mission.vehicles.px4_multicopter.vehicle:PX4_MULTICOPTER", "x"),
    ]
    monkeypatch.setattr(register, "plug_ins", lambda group: entries)
    assert list(register._registered.__wrapped__()) == ["px4"]
    namesake = type(Autopilot.PX4)()
    monkeypatch.setattr("ipoa_mission.vehicles.arducopter.vehicle.ARDUCOPTER", namesake)
    entries.append(EntryPoint("px4", "ipoa_mission.vehicles.arducopter.vehicle:ARDUCOPTER", "x"))
    with refuses("bad-input", "", "px4"):
        register._registered.__wrapped__()
