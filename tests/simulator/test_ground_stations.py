import math

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.commands import VehicleCommand
from ipoa_mission.autopilot.guidance_profile import mode_number
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link.definitions import definition_of
from ipoa_mission.link.messages import (
    Attitude,
    BatteryStatus,
    ClearAll,
    CommandAck,
    CommandLong,
    CommandResult,
    Gps,
    Heartbeat,
    Hud,
    LocalPosition,
    ParamRequestList,
    ParamValue,
    Position,
    ProtocolVersion,
    RequestDataStream,
    SystemStatus,
    Text,
    TimeSync,
)
from ipoa_mission.link.orders import parameter_value
from ipoa_mission.mission.items import waypoint
from tests.link_pair import HOME
from tests.simulator.flown import Flown

ARDUPILOT, PX4 = Autopilot.ARDUPILOT, Autopilot.PX4
OK = CommandResult.ACCEPTED


@pytest.mark.parametrize(
    ("autopilot", "number", "result"),
    [
        (PX4, VehicleCommand.REQUEST_MESSAGE, CommandResult.ACCEPTED),
        (PX4, VehicleCommand.REQUEST_PROTOCOL_VERSION, CommandResult.ACCEPTED),
        (ARDUPILOT, VehicleCommand.REQUEST_MESSAGE, CommandResult.FAILED),
        (ARDUPILOT, VehicleCommand.REQUEST_PROTOCOL_VERSION, CommandResult.UNSUPPORTED),
    ],
)
def test_px4_tells_its_version_of_mavlink_when_asked(autopilot: Autopilot, number: int, result: int) -> None:
    """Without it QGroundControl takes the old mission protocol, which has neither fence nor rally points."""
    params = (float(definition_of("PROTOCOL_VERSION").number), *(0.0,) * 6)
    messages = Flown(autopilot, []).hear(CommandLong(number, params))
    assert CommandAck(number, result) in messages
    versions = [message for message in messages if isinstance(message, ProtocolVersion)]
    assert versions == ([ProtocolVersion(200, 100, 203)] if result == CommandResult.ACCEPTED else [])


def rates(flown: Flown, *kinds: type) -> list[int]:
    messages = flown.fly(10.0)
    return [sum(isinstance(message, kind) for message in messages) for kind in kinds]


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


#: QGroundControl v4.4 reports these missing in a dialog.
WANTED = {
    PX4: "CAL_GYRO0_ID CAL_ACC0_ID CAL_MAG0_ID CAL_MAG1_ID CAL_MAG2_ID SYS_AUTOCONFIG RC_MAP_ROLL RC_MAP_PITCH "
    "RC_MAP_YAW RC_MAP_THROTTLE RC_MAP_FLTMODE COM_FLTMODE1 COM_FLTMODE2 COM_FLTMODE3 COM_FLTMODE4 COM_FLTMODE5 "
    "COM_FLTMODE6 BAT1_N_CELLS BAT1_V_EMPTY BAT1_V_CHARGED COM_RC_LOSS_T NAV_RCL_ACT COM_LOW_BAT_ACT",
    ARDUPILOT: "RCMAP_ROLL RCMAP_PITCH RCMAP_THROTTLE RCMAP_YAW RC1_MIN RC1_TRIM RC1_MAX RC4_DZ RC4_REVERSED FLTMODE1",
}


@pytest.mark.parametrize("autopilot", registered())
def test_the_parameters_that_a_ground_station_looks_for_are_there(autopilot: Autopilot) -> None:
    values = [message for message in Flown(autopilot, []).hear(ParamRequestList()) if isinstance(message, ParamValue)]
    by_name = {value.param_id: value for value in values}
    assert set(WANTED[autopilot].split()) <= set(by_name)
    assert {value.param_count for value in values} == {len(by_name)}
    name, value, kind = ("BAT1_N_CELLS", 4.0, 6) if autopilot is PX4 else ("RC3_DZ", 30.0, 4)
    assert (parameter_value(by_name[name], autopilot), by_name[name].param_type) == (value, kind)


def test_a_battery_is_told() -> None:
    flown = Flown(PX4, [])
    battery = next(message for message in flown.fly(2.1) if isinstance(message, BatteryStatus))
    assert battery.battery_remaining == 100
    assert battery.voltage > 10.0


# --- orders in flight: as measured on PX4 1.17 ----------------------------------------------------------------------

HOLD, TAKEOFF, MISSION = (mode_number(4, sub) for sub in (3, 2, 4))
NAN = math.nan


@pytest.mark.parametrize(
    ("autopilot", "flags", "result"),
    [
        (PX4, 1.0, CommandResult.ACCEPTED),
        (PX4, 0.0, CommandResult.UNSUPPORTED),
        (PX4, 3.0, CommandResult.UNSUPPORTED),
        (PX4, NAN, CommandResult.UNSUPPORTED),
        (ARDUPILOT, 1.0, CommandResult.UNSUPPORTED),  # the real one flies there in GUIDED
    ],
)
def test_vehicle_on_the_ground_goes_nowhere(autopilot: Autopilot, flags: float, result: int) -> None:
    flown = Flown(autopilot, [])
    flown.command(VehicleCommand.DO_SET_MODE, 1.0, 4.0, 2.0)
    assert flown.command(VehicleCommand.DO_REPOSITION, -1.0, flags, 0.0, NAN, 47.41, 8.51, 450.0) == result
    flown.fly(3.0)
    assert flown.mock.flight.on_ground
    if autopilot is PX4:
        assert flown.mock.vehicle.mode == (HOLD if result == OK else TAKEOFF)


def test_px4_without_a_mission_accepts_its_mode_and_then_refuses_it() -> None:
    """Two answers to one order: the first is only that it was heard."""
    flown = Flown(PX4, [waypoint(Geodetic(HOME.latitude_deg + 0.002, HOME.longitude_deg), 20.0)])
    assert flown.command(VehicleCommand.MISSION_START) == OK
    flown.fly(15.0)
    flown.command(VehicleCommand.DO_SET_MODE, 1.0, 4.0, 3.0)
    assert flown.command(VehicleCommand.DO_SET_MODE, 1.0, 4.0, 4.0) == OK
    assert flown.mock.vehicle.mode == MISSION
    flown.command(VehicleCommand.DO_SET_MODE, 1.0, 4.0, 3.0)
    flown.hear(ClearAll())
    messages = flown.hear(CommandLong(VehicleCommand.DO_SET_MODE, (1.0, 4.0, 4.0, 0.0, 0.0, 0.0, 0.0)))
    results = [each.result for each in messages if isinstance(each, CommandAck)]
    assert results == [OK, CommandResult.TEMPORARILY_REJECTED]
    assert any(isinstance(m, Text) and "Switching to Mission is currently not available" in m.text for m in messages)
    assert flown.mock.vehicle.mode == HOLD
