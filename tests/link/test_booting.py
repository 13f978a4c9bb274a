from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import replace

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.commands import Command
from ipoa_mission.flight.procedure import Stage, fly_mission
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link.codec import Codec, Target
from ipoa_mission.link.connect import meet
from ipoa_mission.link.connection import Connection
from ipoa_mission.link.dialogue import SPECIFIED
from ipoa_mission.link.messages import CRITICAL, CommandLong, Count, ItemAt, Message
from ipoa_mission.link.orders import CommandRefused
from ipoa_mission.link.upload import Replaced
from ipoa_mission.link.vehicle import ConnectionOptions, Vehicle
from ipoa_mission.link.vehicle_state import NotReady
from ipoa_mission.mission.items import Mission, land, takeoff
from ipoa_mission.mission.stored_mission import to_wire
from ipoa_mission.progress import Progress
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot
from ipoa_mission.simulator.situation import Conditions
from ipoa_mission.simulator.station import Loopback, Station
from tests.link.suited import suited
from tests.px4_waypoints import waypoint
from tests.refused import refuses

PX4, ARDUPILOT = Autopilot.PX4, Autopilot.ARDUPILOT
HOME = Geodetic(47.4, 8.5, 400.0)
THERE = Geodetic(47.4002, 8.5)
MISSION = Mission(HOME, (takeoff(HOME, 5.0), waypoint(THERE, 5.0), land(THERE)))
#: Position of each stand-in, long after passed checks [s].
PLACED_S = {ARDUPILOT: 41.4, PX4: 40.0}


class Booting(BuiltInAutopilot):
    """Reports passed checks before it can be armed, as real ones do."""

    def __init__(self, autopilot: Autopilot, hinders: str = "", placed_s: float = 0.0) -> None:
        super().__init__(autopilot, HOME, conditions=Conditions(cold=True))
        self.armings_s: list[float] = []
        start_up = replace(self.profile.start_up, steady_s=5.0, position_s=placed_s or PLACED_S[autopilot])
        profile = replace(self.profile, start_up=replace(start_up, unplaced=hinders or start_up.unplaced))
        self.profile = self.vehicle.profile = profile

    def receive(self, message: Message, source: Target, now: float) -> None:
        if isinstance(message, CommandLong) and message.command == Command.COMPONENT_ARM_DISARM:
            assert message.params[0] == 1.0  # one that was not armed is not disarmed either
            self.armings_s.append(now)
        super().receive(message, source, now)


def met(autopilot: BuiltInAutopilot, total_s: float = SPECIFIED.total_s) -> Vehicle:
    connection = Connection(Loopback(Station(autopilot)), Codec(245, 190))
    return meet(connection, options=ConnectionOptions(retry_policy=replace(SPECIFIED, total_s=total_s)))


class RecordedStages:
    def __init__(self) -> None:
        self.words: list[tuple[Stage, str]] = []

    @contextmanager
    def stage(self, stage: Stage) -> Iterator[Progress]:
        yield lambda _, words: self.words.append((stage, words))


@pytest.mark.parametrize("autopilot", registered())
def test_one_that_refuses_to_be_armed_until_it_has_a_position_is_flown(autopilot: Autopilot) -> None:
    booting, conversation = Booting(autopilot), RecordedStages()
    with met(booting) as vehicle:
        record = fly_mission(vehicle, suited(vehicle, MISSION), stages=conversation.stage)
    assert record.completed
    assert len(booting.armings_s) > 1
    assert booting.armings_s[-2] < PLACED_S[autopilot] <= booting.armings_s[-1] < PLACED_S[autopilot] + 10.0
    reason = "Arm: Need Position Estimate" if autopilot is ARDUPILOT else "Arming denied: Resolve system health"
    assert any(stage is Stage.START and f"not armed yet: {reason}" in words for stage, words in conversation.words)


@pytest.mark.parametrize(("origin_s", "code"), [(6.0, None), (1e9, "unflyable")])
def test_px4_judges_a_mission_once_it_has_its_home(origin_s: float, code: str | None) -> None:
    """8 of 9 uploads right after a boot of PX4 1.17 or 1.18 were taken for refused, and accepted 2 s later."""
    booting = Booting(PX4)
    start_up = replace(booting.profile.start_up, origin_s=origin_s)
    booting.profile = booting.vehicle.profile = replace(booting.profile, start_up=start_up)
    shown = list[str]()
    with met(booting) as vehicle:
        booting.vehicle.send_text(CRITICAL, "Preflight Fail: no heading reference")
        with nullcontext() if code is None else refuses(code, "", "no reason was heard") as refused:
            vehicle.upload(suited(vehicle, MISSION), lambda _, words: shown.append(words))
        assert origin_s < vehicle.connection.now() < 9.0 or code is not None
    assert any("not judged yet" in words for words in shown)
    assert refused is None or "position" in str(refused.value.hint)


@pytest.mark.parametrize("autopilot", registered())
def test_a_mission_that_is_replaced_while_it_is_waited_for_is_not_flown(autopilot: Autopilot) -> None:
    booting = Booting(autopilot)
    longer = replace(MISSION, autopilot=autopilot, items=(MISSION.items[0], *MISSION.items))

    @contextmanager
    def replaced_meanwhile(stage: Stage) -> Iterator[Progress]:
        def replace_once(_share: float, words: str) -> None:
            if stage is Stage.START and len(booting.armings_s) == 1 and words:
                items, stranger = to_wire(longer), Target(250, 190)
                booting.receive(Count(len(items)), stranger, vehicle.connection.now())
                for seq, item in enumerate(items):
                    booting.receive(ItemAt(seq, item), stranger, vehicle.connection.now())

        yield replace_once

    with met(booting) as vehicle, pytest.raises((Replaced, NotReady)):
        fly_mission(vehicle, suited(vehicle, MISSION), stages=replaced_meanwhile)
    assert len(booting.armings_s) == 1
    assert not booting.flight.armed


@pytest.mark.parametrize("autopilot", registered())
def test_the_user_s_patience_ends_the_waiting_with_the_vehicle_s_reason(autopilot: Autopilot) -> None:
    booting = Booting(autopilot, placed_s=1e9)
    with met(booting, total_s=100.0) as vehicle:
        begun = vehicle.connection.now()
        with refuses("not-ready"):
            fly_mission(vehicle, suited(vehicle, MISSION))
        assert 100.0 < vehicle.connection.now() - begun < 130.0


@pytest.mark.parametrize(
    ("autopilot", "hinders"),
    [
        (ARDUPILOT, "Hardware safety switch"),
        (ARDUPILOT, "RC3_MIN is greater than RC3_TRIM"),
        (ARDUPILOT, "Battery 1 low voltage failsafe"),
        (ARDUPILOT, "Vehicle breaching Polygon fence"),
        (PX4, "high throttle"),
    ],
)
def test_lasting_refusal_ends_at_once_with_the_vehicle_s_reason(autopilot: Autopilot, hinders: str) -> None:
    booting = Booting(autopilot, hinders, placed_s=1e9)
    with met(booting) as vehicle:
        with pytest.raises((NotReady, CommandRefused)) as refused:
            fly_mission(vehicle, suited(vehicle, MISSION))
        assert hinders in str(refused.value)
        assert vehicle.connection.now() < booting.profile.start_up.origin_s + 40.0
    assert len(booting.armings_s) <= 1


PASSES = {
    ARDUPILOT: """
        Need Position Estimate; Need Alt Estimate; AHRS: waiting for home; AHRS: EKF3 still initialising; AHRS:
        Waiting for 3D fix; AHRS: EKF starting GPS checks; AHRS: GPS numsats 5 (needs 6); AHRS: GPS horiz error 9.1m
        (needs 5.0); AHRS: GPS speed error 2.1 (needs < 1.0); AHRS: Mag yaw error x=1.2 y=0.1; AHRS: GPS vertical
        speed 0.41m/s (needs 0.30); AHRS: EKF3 Yaw inconsistent 31 deg. Wait or reboot; AHRS: not using configured
        AHRS type; AHRS: EKF3 not started; AHRS: EKF3 core 0 unhealthy; AHRS: Not healthy; AHRS not healthy; EKF
        attitude is bad; EKF compass variance; GPS 1: Bad fix; GPS 2: not healthy; High GPS HDOP; GPS glitching; GPS
        and AHRS differ by 12.1m; Gyros inconsistent; Gyros not calibrated; Accels inconsistent; Gyros not healthy;
        Compass not healthy; Compass calibration running; temperature cal running; heater temp low (21.0 < 45);
        Fence requires position; Fence enabled, need position estimate; System not initialised; Logging not started;
        Main loop slow (301Hz < 400Hz); Altitude disparity; waiting for terrain data; Baro: not healthy
    """,
    PX4: """
        Resolve system health failures first; Resolve system health failures fir; calibrating; ekf2 missing data;
        heading estimate not stable; height estimate not stable; horizontal position unstable; GPS fix too low;
        vertical velocity unstable; Global position estimate required; Home position required; Accel Sensor 0
        missing; not enough GPS Satellites; Poor GPS Quality; Estimator not using GPS; High Gyro Bias; barometer 0
        missing; No valid data from Gyro 0; No connection to the GCS; CPU load too high: 96.1%
    """,
}
STAYS = {
    ARDUPILOT: """
        Hardware safety switch; Safety Switch; RC not found; RC3_MIN is greater than RC3_TRIM; RC calibrating;
        Throttle below failsafe; Radio failsafe on; Battery failsafe; Battery 1 low voltage failsafe; Fences
        enabled, but none selected; Invalid FENCE_ALT_MAX value; Vehicle breaching Max Alt fence; 3D Accel
        calibration needed; Accels calibrated requires reboot; Compass calibrated requires reboot; Compass offsets
        too high; Check mag field: 900, max 875, min 185; Motors: Check frame class and type; AHRS: EK3_MAG_CAL and
        EK3_SRC1_YAW inconsistent; AHRS: Check EK3_SRC1_POSXY; AHRS: invalid EKF type; GPS 1: primary but TYPE 0;
        Logging failed; No SD card; Leaning; Internal errors 0x800 l:311 mem_guard; Throttle too high; AUTO mode not
        armable; Motors Emergency Stopped; Compasses inconsistent; RNGFND1_PIN not set; Missing mission item: land;
        Bad parameter: ATC_ANG_RLL_P must be > 0
    """,
    PX4: """
        high throttle; throttle above center; switch to manual mode first; Press safety button first; GPS signal
        spoofed; Kill switch engaged; Battery unhealthy; Gyro 0 uncalibrated; Compass 0 uncalibrated; RC ERROR:
        RC1_MIN < 700; Power module not connected; Missing FMU SD Card; Crash dumps present on SD; Flight
        termination active; Parachute system missing; Strong magnetic interference; Motor failure detected; Attitude
        failure (roll)
    """,
}
BEGINS = {ARDUPILOT: ("PreArm: ", "Arm: "), PX4: ("Arming denied: ", "Preflight Fail: ")}


@pytest.mark.parametrize("autopilot", registered())
def test_the_reasons_of_the_firmware_s_sources_are_told_apart(autopilot: Autopilot) -> None:
    words = autopilot.protocol_profile.arming_words
    for begin in BEGINS[autopilot]:
        passing, staying = (
            [begin + " ".join(reason.split()) for reason in listed[autopilot].split(";")] for listed in (PASSES, STAYS)
        )
        assert words.lasting("; ".join(passing)) == ()
        assert words.lasting("; ".join(staying)) == tuple(staying)
        assert words.lasting("; ".join(passing + staying[:1])) == (staying[0],)
    assert words.reasons("EKF3 IMU0 is using GPS; GPS 1: detected u-blox") == ()
