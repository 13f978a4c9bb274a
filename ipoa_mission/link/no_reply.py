from collections.abc import Mapping

from ipoa_mission.errors import MissionError
from ipoa_mission.link.signing import Doubt

#: Silence until the cause is reported [s].
CAUSE_S = 5.0
#: To listen for another vehicle [s].
DOUBTED_S = 3.0
_WORDS: Mapping[Doubt | None, tuple[str, str]] = {
    None: ("it signs its messages, and does not answer our unsigned ones", "give the key that it has: --key FILE"),
    Doubt.UNSIGNED: (
        "it does not sign, and only messages signed with our key are accepted",
        "give it this key, or connect without one",
    ),
    Doubt.FOREIGN: ("it signs with another key than ours", "give the key that it has: --key FILE"),
    Doubt.STALE: (
        "it signs with our key, but its timestamps are old",
        "is its clock wrong, or this computer's? Or are old messages replayed?",
    ),
}


class SpeaksMavlink1(MissionError):
    """The vehicle is heard in MAVLink 1 only, and ignores MAVLink 2."""

    def __init__(self, system: int) -> None:
        super().__init__(
            f"vehicle {system} speaks MAVLink 1 only, and does not answer to MAVLink 2",
            hint="set it to MAVLink 2 on this link (ArduPilot: SERIALn_PROTOCOL 2, PX4: MAV_PROTO_VER 2)",
        )


class SignsOtherwise(MissionError):
    """The vehicle's signing and ours differ: it ignores us."""

    def __init__(self, system: int, doubt: Doubt | None) -> None:
        words, hint = _WORDS[doubt]
        super().__init__(f"vehicle {system} is there, but {words}", hint=hint)
