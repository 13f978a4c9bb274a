from pathlib import Path

import pytest

from tools.generate import copter_source, px4_source
from tools.generate.sources import Source, cases, preprocessed

COPTER_H = """
struct PACKED Speed_Command { uint8_t kind; float meters; float share; };
struct PACKED Rope_Command { bool taut; uint16_t length_cm; };
union Content { Speed_Command speed; Rope_Command rope; };
"""
COPTER = """
R AP_Mission::sanity_check_params(P packet) {
  switch (packet.command) {
  case MAV_CMD_NAV_WAYPOINT: mask = ~(1 << 3); break;
  default: mask = 0xff; break;
  }
}
R AP_Mission::mavlink_int_to_mission_cmd(P packet, C& cmd) {
  switch (cmd.id) {
  case MAV_CMD_NAV_WAYPOINT: {
#if APM_BUILD_TYPE(APM_BUILD_ArduPlane)
    cmd.p1 = packet.param2;
#else
    if (packet.param1 < 0 || packet.param1 > UINT16_MAX) { return MAV_MISSION_INVALID_PARAM1; }
    cmd.p1 = packet.param1;
#endif
  } break;
  case MAV_CMD_DO_CHANGE_SPEED:
    cmd.content.speed.kind = packet.param1;
    cmd.content.speed.meters = packet.param2;
    break;
  case MAV_CMD_DO_WINCH:
    cmd.content.rope.taut = packet.param1 > 0;
    cmd.content.rope.length_cm = packet.param3 * 100;
    break;
  default: return UNSUPPORTED;
  }
}
B AP_Mission::mission_cmd_to_mavlink_int(C cmd, P& packet) {
  switch (cmd.id) {
  case MAV_CMD_NAV_WAYPOINT: packet.param1 = cmd.p1; break;
  case MAV_CMD_DO_CHANGE_SPEED:
    packet.param1 = cmd.content.speed.kind;
    packet.param2 = cmd.content.speed.meters;
    break;
  case MAV_CMD_DO_WINCH:
    packet.param1 = cmd.content.rope.taut ? 1 : 0;
    packet.param3 = cmd.content.rope.length_cm * 0.01f;
    break;
  }
}
bool AP_Mission::stored_in_location(int id) { switch (id) { case MAV_CMD_NAV_WAYPOINT: return true; } }
"""
MASKS = """
{   16, 0x7B, 0x7B },
{   22, 0x78, 0x78 },
{  999, 0x01, 0x01 },
{ 22, VEHICLE_FW | VEHICLE_MC, 0x01, 0x01 },
"""


@pytest.fixture
def copter(monkeypatch: pytest.MonkeyPatch) -> Source:
    texts = {copter_source.CODE: COPTER, copter_source.HEADER: COPTER_H}
    monkeypatch.setattr(
        Source, "text", lambda self, path: texts[path].replace("// a comment: case MAV_CMD_NAV_LAND:", "")
    )
    return Source(Path(), "HEAD")


def test_rows_are_read_by_what_each_param_is_kept_in(copter: Source) -> None:
    read = copter_source.facts(copter)
    assert read["placed"] == {"NAV_WAYPOINT": "w---ddc"}
    assert read["plain"] == {"DO_CHANGE_SPEED": "w.-----", "DO_WINCH": "b-c----"}
    assert read["nan"] == {"NAV_WAYPOINT": "4"}


def test_unreadable_sources_end_the_tool(copter: Source, monkeypatch: pytest.MonkeyPatch) -> None:
    odd = COPTER.replace("speed.kind = packet.param1", "speed.kind = guessed(1)")
    texts = {copter_source.CODE: odd, copter_source.HEADER: COPTER_H}
    monkeypatch.setattr(Source, "text", lambda self, path: texts[path])
    with pytest.raises(SystemExit, match="DO_CHANGE_SPEED: expected param1 to be kept in content"):
        copter_source.facts(copter)


def test_used_params_of_a_multicopter() -> None:
    assert px4_source._used(MASKS) == {"used": {"NAV_WAYPOINT": "1 2 4 5 6 7", "NAV_TAKEOFF": "1 4 5 6 7", "999": "1"}}
    assert px4_source._used("") == {}


def test_the_other_branch_of_a_condition_and_labels_that_share_code() -> None:
    assert preprocessed("#if A\none\n#else\ntwo\n#endif\n#if B\nthree\n#endif", "A") == "two\nthree"
    assert list(cases("case A: case B: one(); break; default: two();")) == [
        (("A", "B"), " one(); break; "),
        (("default",), " two();"),
    ]
