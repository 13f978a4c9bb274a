"""What ground stations ask besides missions: streams the old way, MAVLink's version, a battery, "go there"."""

import pytest

from ipoa_mission.autopilots.vehicle import Autopilot
from ipoa_mission.commands import Order
from ipoa_mission.link.definitions import message_number
from ipoa_mission.link.messages import (
    CommandAck,
    CommandLong,
    CommandResult,
    Heartbeat,
    ParamRequestList,
    ParamValue,
    RequestDataStream,
    TimeSync,
)
from ipoa_mission.link.orders import parameter_value
from ipoa_mission.link.telemetry import (
    Attitude,
    BatteryStatus,
    Gps,
    Hud,
    LocalPosition,
    Position,
    ProtocolVersion,
    SystemStatus,
)
from tests.simulator.flown import Flown

ARDUPILOT, PX4 = Autopilot.ARDUPILOT, Autopilot.PX4


@pytest.mark.parametrize(
    ("autopilot", "number", "result"),
    [
        (PX4, Order.REQUEST_MESSAGE, CommandResult.ACCEPTED),
        (PX4, Order.REQUEST_PROTOCOL_VERSION, CommandResult.ACCEPTED),
        (ARDUPILOT, Order.REQUEST_MESSAGE, CommandResult.FAILED),
        (ARDUPILOT, Order.REQUEST_PROTOCOL_VERSION, CommandResult.UNSUPPORTED),
    ],
)
def test_px4_tells_its_version_of_mavlink_when_asked(autopilot: Autopilot, number: int, result: int) -> None:
    """Without it QGroundControl takes the old mission protocol, which has neither fence nor rally points."""
    params = (float(message_number("PROTOCOL_VERSION")), *(0.0,) * 6)
    said = Flown(autopilot, []).hear(CommandLong(number, params))
    assert CommandAck(number, result) in said
    told = [message for message in said if isinstance(message, ProtocolVersion)]
    assert told == ([ProtocolVersion(200, 100, 203)] if result == CommandResult.ACCEPTED else [])


def rates(flown: Flown, *kinds: type) -> list[int]:
    """How often each kind is told in ten seconds."""
    said = flown.fly(10.0)
    return [sum(isinstance(message, kind) for message in said) for kind in kinds]


def test_ardupilot_turns_groups_of_messages_on_and_off_the_old_way() -> None:
    flown = Flown(ARDUPILOT, [])
    kinds = (Gps, SystemStatus, Position, LocalPosition, Attitude, Hud, BatteryStatus)
    assert rates(flown, *kinds) == [0] * 7
    flown.hear(RequestDataStream(6, 3))  # position
    assert rates(flown, *kinds) == [0, 0, pytest.approx(30, abs=1), pytest.approx(30, abs=1), 0, 0, 0]
    flown.hear(RequestDataStream(0, 4))  # all
    assert rates(flown, *kinds) == [pytest.approx(40, abs=1)] * 7
    flown.hear(RequestDataStream(11, 4, start_stop=0))
    flown.hear(RequestDataStream(10, 0))
    flown.hear(RequestDataStream(2, 9, start_stop=7))  # means nothing
    flown.hear(RequestDataStream(99, 9))
    assert rates(flown, *kinds) == [*[pytest.approx(40, abs=1)] * 4, 0, 0, pytest.approx(40, abs=1)]
    flown.hear(RequestDataStream(0, 0))
    assert rates(flown, *kinds) == [0] * 7
    assert rates(flown, Heartbeat, TimeSync) == [10, 1], "these belong to no group"


def test_px4_has_no_groups() -> None:
    flown = Flown(PX4, [])
    flown.fly(0.1)
    before = rates(flown, Position, Hud, BatteryStatus)
    flown.hear(RequestDataStream(0, 0))
    assert rates(flown, Position, Hud, BatteryStatus) == before == [50, 40, 5]


#: What QGroundControl v4.4 misses, in a dialog, where a vehicle does not have it.
WANTED = {
    PX4: "CAL_GYRO0_ID CAL_ACC0_ID CAL_MAG0_ID CAL_MAG1_ID CAL_MAG2_ID SYS_AUTOCONFIG RC_MAP_ROLL RC_MAP_PITCH "
    "RC_MAP_YAW RC_MAP_THROTTLE RC_MAP_FLTMODE COM_FLTMODE1 COM_FLTMODE2 COM_FLTMODE3 COM_FLTMODE4 COM_FLTMODE5 "
    "COM_FLTMODE6 BAT1_N_CELLS BAT1_V_EMPTY BAT1_V_CHARGED COM_RC_LOSS_T NAV_RCL_ACT COM_LOW_BAT_ACT",
    ARDUPILOT: "RCMAP_ROLL RCMAP_PITCH RCMAP_THROTTLE RCMAP_YAW RC1_MIN RC1_TRIM RC1_MAX RC4_DZ RC4_REVERSED FLTMODE1",
}


@pytest.mark.parametrize("autopilot", Autopilot)
def test_the_parameters_that_a_ground_station_looks_for_are_there(autopilot: Autopilot) -> None:
    values = [said for said in Flown(autopilot, []).hear(ParamRequestList()) if isinstance(said, ParamValue)]
    told = {value.param_id: value for value in values}
    assert set(WANTED[autopilot].split()) <= set(told)
    assert {value.param_count for value in values} == {len(told)}
    name, value, kind = ("BAT1_N_CELLS", 4.0, 6) if autopilot is PX4 else ("RC3_DZ", 30.0, 4)
    assert (parameter_value(told[name], autopilot), told[name].param_type) == (value, kind)


def test_a_battery_is_told() -> None:
    flown = Flown(PX4, [])
    battery = next(said for said in flown.fly(2.1) if isinstance(said, BatteryStatus))
    assert battery.battery_remaining == 100
    assert battery.voltage > 10.0
