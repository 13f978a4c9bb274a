from pymavlink.dialects.v20 import ardupilotmega

from ipoa_mission.link import definitions
from ipoa_mission.link.codec import Codec, Target
from ipoa_mission.link.messages import ParamSet


def test_the_table_is_pymavlinks_with_what_the_stable_dialects_lack() -> None:
    known = {definitions.DEFINITIONS[number].name for number in ardupilotmega.mavlink_map}
    assert known == {kind.msgname for kind in ardupilotmega.mavlink_map.values()}
    assert "opaque_id" in definitions.definition_of("MISSION_ACK").names


def test_a_text_is_packed_as_pymavlink_packs_it() -> None:
    built = ardupilotmega.MAVLink_param_set_message(1, 1, b"RTL_ALT", 6500.0, 9)
    ours = Codec(255, 190).encode(ParamSet("RTL_ALT", 6500.0), Target(1, 1), 0.0)
    assert ours == bytes(built.pack(ardupilotmega.MAVLink(None, 255, 190)))
    heard = Codec(1, 1).decode(ours)
    assert heard is not None
    assert heard.message == ParamSet("RTL_ALT", 6500.0)


def test_known_params_of_commands_are_explained() -> None:
    assert definitions.labeled_params(177) == {1: ("Number", "", "Sequence number"), 2: ("Repeat", "", "Repeat count")}
    assert definitions.labeled_params(16)[2][:2] == ("Accept Radius", "m")
    assert definitions.labeled_params(183)[2][:2] == ("PWM", "us")
    assert definitions.labeled_params(64_999) == {}
