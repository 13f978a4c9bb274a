"""What a mission file holds: the mission, what reading it had to say, and the text itself."""

from dataclasses import dataclass, replace

from ipoa_mission.finding import Finding
from ipoa_mission.mission.items import Mission


@dataclass(frozen=True)
class MissionFile:
    """What was read from a mission file.

    Attributes:
        mission: as it was read.
        findings: what was odd in the file.
        source: its text.
        suffix: of its format, ".plan" or ".waypoints".
        planned: the NAME.json that was written with it, and the time that this has for it [s].
        taken_for: why it is read for its autopilot, where nothing says for which it is; "": it is the default one.
    """

    mission: Mission
    findings: tuple[Finding, ...]
    source: str
    suffix: str
    planned: tuple[str, float] | None = None
    taken_for: str | None = None

    def still_holds(self, mission: Mission) -> bool:
        """Whether it says all of this mission, but for the parameters, which lie beside it."""
        return repr(replace(mission, parameters={})) == repr(replace(self.mission, parameters={}))  # a NaN is no other
