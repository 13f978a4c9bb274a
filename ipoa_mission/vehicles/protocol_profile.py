"""Properties of an autopilot's mission protocol and of how it starts a mission."""

from dataclasses import dataclass

from ipoa_mission.vehicles.arming import NO_ARMING_WORDS, ArmingWords


@dataclass(frozen=True)
class ProtocolProfile:
    """Protocol behavior that differs between autopilots."""

    forgets_at_count: bool = False
    """A transfer deletes the old mission or rally points at once; a fence is replaced at once."""
    judges_later: bool = False
    """It reports whether it can fly a mission after the acknowledgement."""
    starts_by_command: bool = False
    """Once armed it waits for MISSION_START."""
    pauses_in_mission: bool = False
    """DO_PAUSE_CONTINUE pauses it within mission mode."""
    takes_mission_file: bool = False
    """It accepts a mission as a file over MAVFTP."""
    boots_slowly: bool = False
    """After power-up it answers before its storage is read."""
    tells_items: bool = False
    """Its status texts name the item that begins."""
    parameters_by_name: bool = False
    """A parameter requested by name is sent without its index."""
    keeps_types: bool = False
    """Setting a parameter with another type than its own has no effect."""
    limits_are_bits: str = ""
    """The parameter whose bits activate the limits of its own fence."""
    arming_words: ArmingWords = NO_ARMING_WORDS
    """Patterns of its arming refusals."""
    widen_fence: str = "give the vehicle a wider fence; --anyway sends it all the same"
    """The hint for an own fence that is too narrow."""
