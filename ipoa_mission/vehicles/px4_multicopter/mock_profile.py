from ipoa_mission.autopilot.commands import Command, VehicleCommand
from ipoa_mission.autopilot.guidance_profile import mode_number
from ipoa_mission.link.conversations import RequestStyle
from ipoa_mission.link.messages import CommandResult, MissionType
from ipoa_mission.simulator.mock_profile import BYTEWISE, CAPABILITIES, Answer, MockProfile, StartUp, asks_every
from ipoa_mission.simulator.situation import FlightMode
from ipoa_mission.vehicles.px4_multicopter.flight_controller import Px4Controller
from ipoa_mission.vehicles.px4_multicopter.vehicle import PX4_MULTICOPTER

MOCK_PROFILE = MockProfile(
    autopilot=PX4_MULTICOPTER,
    controller=Px4Controller,
    protocol_profile=RequestStyle(),
    patience=asks_every(0.25, 5.0),
    timeout_text="Operation timeout",
    count_from_stranger=Answer.ERROR,
    count_again=Answer.ERROR,
    read_during_upload=Answer.TEXT,
    clear_during_upload=Answer.TEXT,
    obeys_cancel=True,
    stray_item=Answer.SILENCE,
    confirms_last_item_again=True,
    reached_repeats=10,
    reached_slot_s=0.1,
    clears_all=True,
    flags_kept=frozenset({MissionType.MISSION, MissionType.RALLY}),
    int_frames=True,
    reports_list_id=True,
    no_total=65535,
    no_item_text="WPM: WP CURR CMD: Not in list\t",
    flight_texts=True,
    restores_mode=True,
    unsupported=frozenset({
        Command.DO_FENCE_ENABLE, Command.DO_PAUSE_CONTINUE, VehicleCommand.DO_SET_MISSION_CURRENT,
    }),
    start_up=StartUp(0.5, 1.0, 1.5, 1.5, *(3 * ("Resolve system health failures first",))),
    modes={
        FlightMode.HOLD: mode_number(4, 3),
        FlightMode.MISSION: mode_number(4, 4),
        FlightMode.RETURN: mode_number(4, 5),
        FlightMode.LAND: mode_number(4, 6),
    },
    first_mode=mode_number(4, 3),
    placed_modes=frozenset(mode_number(4, sub) for sub in range(2, 7)),
    armable_modes=frozenset({mode_number(4, 2), mode_number(4, 3), mode_number(4, 4)}),
    takeoff_mode=mode_number(4, 2),
    mission_arms=True,
    refused_arming=CommandResult.TEMPORARILY_REJECTED,
    arm_texts=(
        "Armed by external command\t", "Disarmed by external command\t", "Disarmed by landing\t",
        "Disarmed by auto preflight disarming\t",
    ),
    disarm_delay="COM_DISARM_PRFLT",
    mode_acks=2,
    streams={
        "HEARTBEAT": 1.0, "SYS_STATUS": 1.0, "SYSTEM_TIME": 1.0, "GPS_RAW_INT": 0.2, "GLOBAL_POSITION_INT": 0.2,
        "LOCAL_POSITION_NED": 1.0, "ATTITUDE": 1.0 / 15, "BATTERY_STATUS": 2.0, "VFR_HUD": 0.25,
        "EXTENDED_SYS_STATE": 1.0, "MISSION_CURRENT": 1.0, "HOME_POSITION": 2.0,
    },
    fixed_streams=frozenset({"HEARTBEAT", "MISSION_CURRENT"}),
    no_such_stream=CommandResult.FAILED,
    no_such_message=CommandResult.DENIED,
    no_such_interval=(-1, CommandResult.ACCEPTED),
    base_mode=29,
    capabilities=CAPABILITIES | BYTEWISE,
    protocol=(200, 100, 203),
)  # fmt: skip
