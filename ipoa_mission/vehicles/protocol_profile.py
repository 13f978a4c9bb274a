"""How an autopilot keeps the mission protocol, and how it is brought to fly: what the link asks of it."""

from dataclasses import dataclass

from ipoa_mission.vehicles.arming import UNTOLD, ArmingWords


@dataclass(frozen=True)
class ProtocolProfile:
    """What one autopilot does on a link that another does not."""

    forgets_at_count: bool = False
    """Its old mission or rally points are gone as soon as a transfer begins; its fence changes at once."""
    judges_later: bool = False
    """After the Ack of a mission it tells whether it can fly it."""
    starts_by_command: bool = False
    """Armed, it waits for MISSION_START."""
    pauses_in_mission: bool = False
    """DO_PAUSE_CONTINUE stops it within its mission mode."""
    takes_mission_file: bool = False
    """A mission may go up as a file over MAVFTP."""
    boots_slowly: bool = False
    """After power-up it answers before it has read its store."""
    tells_items: bool = False
    """Its texts say which item begins."""
    parameters_by_name: bool = False
    """A value that is asked for by name comes without its index."""
    keeps_types: bool = False
    """A parameter that is set with another type than its own stays as it is."""
    limits_are_bits: str = ""
    """The parameter whose bits say which limits of its own fence are in force."""
    arming_words: ArmingWords = UNTOLD
    """Its reasons for not being armed."""
    widen_fence: str = "give the vehicle a wider fence; --anyway sends it all the same"
    """What a user can do about a fence of the vehicle's own that is too narrow."""
