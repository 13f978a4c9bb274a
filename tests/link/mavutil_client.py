"""pymavlink's own tools (mavutil, mavwp) in a process of their own: parameters, upload, download, flight."""

import json
import sys

from pymavlink import mavutil, mavwp


def main(port: str, path: str) -> None:
    link = mavutil.mavlink_connection(f"udpout:127.0.0.1:{port}", source_system=255)
    link.mav.heartbeat_send(6, 8, 0, 0, 0)
    link.wait_heartbeat(timeout=10)
    link.param_fetch_all()
    parameters: dict[str, float] = {}
    while True:
        value = link.recv_match(type="PARAM_VALUE", blocking=True, timeout=5)
        assert value is not None, "the parameters do not all come"
        parameters[value.param_id] = value.param_value
        if len(parameters) == value.param_count:
            break
    loader = mavwp.MAVWPLoader(link.target_system, link.target_component)
    loader.load(path)
    link.waypoint_count_send(loader.count())
    while True:
        asked = link.recv_match(
            type=["MISSION_REQUEST", "MISSION_REQUEST_INT", "MISSION_ACK"], blocking=True, timeout=5
        )
        assert asked is not None, "the upload stalls"
        if asked.get_type() == "MISSION_ACK":
            break
        link.mav.send(loader.wp(asked.seq))
    link.waypoint_request_list_send()
    count = link.recv_match(type="MISSION_COUNT", blocking=True, timeout=5).count
    commands = []
    for seq in range(count):
        link.mav.mission_request_int_send(link.target_system, link.target_component, seq)
        commands.append(link.recv_match(type="MISSION_ITEM_INT", blocking=True, timeout=5).command)
    link.mav.mission_ack_send(link.target_system, link.target_component, 0)
    link.arducopter_arm()
    link.motors_armed_wait()
    link.set_mode("AUTO")
    reached: list[int] = []
    while link.motors_armed():
        heard = link.recv_match(type=["MISSION_ITEM_REACHED", "HEARTBEAT"], blocking=True, timeout=10)
        assert heard is not None, "the vehicle falls silent"
        if heard.get_type() == "MISSION_ITEM_REACHED":
            reached.append(heard.seq)
    link.close()
    told = {"ack": asked.type, "parameters": len(parameters), "commands": commands, "reached": reached}
    sys.stdout.write(json.dumps(told) + "\n")


main(sys.argv[1], sys.argv[2])
