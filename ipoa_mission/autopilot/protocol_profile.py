"""Properties of an autopilot's mission protocol and mission start."""

from dataclasses import dataclass

from ipoa_mission.autopilot.arming import NO_ARMING_WORDS, ArmingWords


@dataclass(frozen=True)
class ProtocolProfile:
    forgets_at_count: bool = False
    """A transfer deletes the old mission or rally points first; a fence is replaced at its end."""
    judges_later: bool = False
    """A transfer deletes the old mission or rally points first; a fence is replaced at once."""
    starts_by_command: bool = False
    """Once armed it waits for MISSION_START."""
    pauses_in_mission: bool = False
    """By DO_PAUSE_CONTINUE."""
    takes_mission_file: bool = False
    """Over MAVFTP."""
    boots_slowly: bool = False
    """It answers before its storage is read."""
    tells_items: bool = False
    """In status texts."""
    parameters_by_name: bool = False
    """The answer has no index."""
    keeps_types: bool = False
    """A set with another type has no effect."""
    limits_are_bits: str = ""
    """The parameter of its own fence's limits."""
    arming_words: ArmingWords = NO_ARMING_WORDS
    widen_fence: str = "give the vehicle a wider fence; --anyway sends it all the same"
    """The hint for a fence that is too narrow."""
