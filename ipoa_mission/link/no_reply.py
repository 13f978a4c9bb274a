"""Why a vehicle that is on the line does not hear us, or is not heard: it signs otherwise, or speaks MAVLink 1."""

from collections.abc import Mapping

from ipoa_mission.errors import MissionError
from ipoa_mission.link.signing import Doubt

#: A vehicle that is heard and has never answered: after so long a silence the cause is named, if there is one [s].
CAUSE_S = 5.0
#: How long one listens for another vehicle after frames of one that is not believed [s].
DOUBTED_S = 3.0
_WORDS: Mapping[Doubt | None, tuple[str, str]] = {
    None: ("it signs what it says, and does not answer us, who do not sign", "give the key that it has: --key FILE"),
    Doubt.UNSIGNED: (
        "it does not sign, and what is not signed with our key is not believed",
        "give it this key, or connect without one",
    ),
    Doubt.FOREIGN: ("it signs with another key than ours", "give the key that it has: --key FILE"),
    Doubt.STALE: (
        "it signs with our key, and its timestamps are old ones",
        "is its clock wrong, or this computer's? Or does somebody play back what it said before?",
    ),
}


class SpeaksMavlink1(MissionError):
    """The vehicle is heard in MAVLink 1 only, and understands nothing that we say."""

    def __init__(self, system: int) -> None:
        super().__init__(
            f"vehicle {system} speaks MAVLink 1 only, and does not answer to MAVLink 2",
            hint="set it to MAVLink 2 on this link (ArduPilot: SERIALn_PROTOCOL 2, PX4: MAV_PROTO_VER 2)",
        )


class SignsOtherwise(MissionError):
    """The vehicle is there; it signs and we do not, or not as we do. Nothing that we said had an effect."""

    def __init__(self, system: int, doubt: Doubt | None) -> None:
        words, hint = _WORDS[doubt]
        super().__init__(f"vehicle {system} is there, but {words}", hint=hint)
