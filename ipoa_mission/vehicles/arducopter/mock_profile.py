from ipoa_mission.autopilot.commands import VehicleCommand
from ipoa_mission.link.conversations import RequestStyle
from ipoa_mission.link.messages import CommandResult, MissionType, Result
from ipoa_mission.simulator.mock_profile import CAPABILITIES, FTP, Answer, MockProfile, StartUp, asks_every
from ipoa_mission.simulator.situation import FlightMode
from ipoa_mission.vehicles.arducopter.flight_controller import ArduCopterController
from ipoa_mission.vehicles.arducopter.vehicle import ARDUCOPTER

MOCK_PROFILE = MockProfile(
    autopilot=ARDUCOPTER,
    controller=ArduCopterController,
    protocol_profile=RequestStyle(legacy=True, rebukes=True),
    patience=asks_every(1.0, 8.0),
    timeout_result=Result.OPERATION_CANCELLED,
    timeout_text="Mission upload timeout",
    truncating=frozenset({MissionType.MISSION, MissionType.RALLY}),
    separate_lists=True,
    reads_item_by_item=True,
    count_from_stranger=Answer.DENIED,
    count_again=Answer.OBEY,
    read_during_upload=Answer.DENIED,
    clear_during_upload=Answer.OBEY,
    stray_item=Answer.ERROR,
    partial_lists=True,
    item_orders={2: Result.ERROR, 3: Result.ACCEPTED},
    reached_slot_s=0.02,
    stored_text={MissionType.MISSION: "Flight plan received"},
    flags_kept=frozenset({MissionType.MISSION}),
    no_total=0,
    missing_takeoff_text="Auto: Missing Takeoff Cmd",
    runs_on_ground=True,
    no_such_mode_text="No such mode",
    refuses_modes=True,
    reboots=True,
    unsupported=frozenset({VehicleCommand.DO_REPOSITION, VehicleCommand.REQUEST_PROTOCOL_VERSION}),
    start_up=StartUp(
        3.0, 20.0, 23.5, 41.4, "Gyros inconsistent", "Need Position Estimate", no_mission="Mode requires mission"
    ),
    modes={FlightMode.HOLD: 5, FlightMode.MISSION: 3, FlightMode.RETURN: 6, FlightMode.LAND: 9},
    first_mode=0,
    placed_modes=frozenset({3, 4, 5, 6, 7, 16, 17, 21, 27}),
    armable_modes=frozenset({0, 1, 2, 4, 5, 16}),
    reports_prearm=True,
    prearm_every_s=1.0,
    refused_arming=CommandResult.FAILED,
    arm_texts=("Arming motors", "Disarming motors", "Disarming motors", "Disarming motors"),
    disarm_delay="DISARM_DELAY",
    acks_first=True,
    heartbeat_on_change=True,
    streams={"HEARTBEAT": 1.0, "TIMESYNC": 10.0},
    no_such_stream=CommandResult.DENIED,
    no_such_message=CommandResult.FAILED,
    no_such_interval=(0, CommandResult.FAILED),
    base_mode=81,
    capabilities=CAPABILITIES | FTP,
    stream_groups={
        2: frozenset({"SYS_STATUS", "MISSION_CURRENT", "GPS_RAW_INT"}),
        6: frozenset({"GLOBAL_POSITION_INT", "LOCAL_POSITION_NED"}),
        10: frozenset({"ATTITUDE"}),
        11: frozenset({"VFR_HUD"}),
        12: frozenset({"SYSTEM_TIME", "BATTERY_STATUS"}),
    },
)
