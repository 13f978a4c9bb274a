"""pymavlink's tools (mavutil, mavparm, mavwp) in a process of their own."""

import json
import sys

from pymavlink import mavparm, mavutil, mavwp


def send(link: mavutil.mavfile, loader: mavwp.MissionItemProtocol) -> int:
    kind = loader.mav_mission_type()
    link.mav.mission_count_send(link.target_system, link.target_component, loader.count(), kind)
    while True:
        asked = link.recv_match(
            type=["MISSION_REQUEST", "MISSION_REQUEST_INT", "MISSION_ACK"], blocking=True, timeout=60
        )
        assert asked is not None, "the upload stalls"
        if asked.mission_type != kind:
            continue  # last item of the list before
        if asked.get_type() == "MISSION_ACK":
            return int(asked.type)
        link.mav.send(loader.wp(asked.seq))


def read(link: mavutil.mavfile, kind: int) -> list[int]:
    link.mav.mission_request_list_send(link.target_system, link.target_component, kind)
    count = link.recv_match(type="MISSION_COUNT", blocking=True, timeout=60).count
    commands = []
    for seq in range(count):
        link.mav.mission_request_int_send(link.target_system, link.target_component, seq, kind)
        commands.append(link.recv_match(type="MISSION_ITEM_INT", blocking=True, timeout=60).command)
    link.mav.mission_ack_send(link.target_system, link.target_component, 0, kind)
    return commands


def main(port: str, path: str, rally_path: str) -> None:
    link = mavutil.mavlink_connection(f"udpout:127.0.0.1:{port}", source_system=255)
    link.mav.heartbeat_send(6, 8, 0, 0, 0)
    link.wait_heartbeat(timeout=60)
    link.mav.request_data_stream_send(link.target_system, link.target_component, 0, 4, 1)
    streams = ["GPS_RAW_INT", "GLOBAL_POSITION_INT", "VFR_HUD", "BATTERY_STATUS", "SYS_STATUS", "MISSION_CURRENT"]
    silent = [name for name in streams if link.recv_match(type=name, blocking=True, timeout=60) is None]
    link.param_fetch_all()
    parameters: dict[str, float] = {}
    while True:
        value = link.recv_match(type="PARAM_VALUE", blocking=True, timeout=60)
        assert value is not None, "the parameters do not all come"
        parameters[value.param_id] = value.param_value
        if len(parameters) == value.param_count:
            break
    loader = mavwp.MAVWPLoader(link.target_system, link.target_component)
    loader.load(path)
    fence = mavwp.MissionItemProtocol_Fence(link.target_system, link.target_component)
    for latitude, longitude in ((47.39, 8.49), (47.41, 8.49), (47.40, 8.51)):
        place = round(latitude * 1e7), round(longitude * 1e7)
        vertex = (link.target_system, link.target_component, 0, 0, 5001, 0, 0, 3, 0, 0, 0, *place, 0, 1)
        fence.add(mavutil.mavlink.MAVLink_mission_item_int_message(*vertex))
    rally = mavwp.MissionItemProtocol_Rally(link.target_system, link.target_component)
    rally.load(rally_path)
    results = [send(link, each) for each in (loader, fence, rally)]
    commands = [read(link, kind) for kind in (0, 1, 2)]
    was_set = mavparm.MAVParmDict().mavset(link, "WPNAV_SPEED", 600.0)
    link.arducopter_arm()
    link.motors_armed_wait()
    link.set_mode("AUTO")
    link.mav.command_long_send(1, 1, mavutil.mavlink.MAV_CMD_MISSION_START, 0, 0, 0, 0, 0, 0, 0, 0)
    reached: list[int] = []
    while link.motors_armed():
        heard = link.recv_match(type=["MISSION_ITEM_REACHED", "HEARTBEAT"], blocking=True, timeout=60)
        assert heard is not None, "the vehicle falls silent"
        if heard.get_type() == "MISSION_ITEM_REACHED":
            reached.append(heard.seq)
    link.close()
    done = {"results": results, "parameters": len(parameters), "commands": commands, "reached": reached, "set": was_set}
    done["silent"] = silent
    sys.stdout.write(json.dumps(done) + "\n")


main(*sys.argv[1:4])
