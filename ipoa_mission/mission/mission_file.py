from dataclasses import dataclass, replace

from ipoa_mission.finding import Finding
from ipoa_mission.mission.items import Mission


@dataclass(frozen=True)
class MissionFile:
    """A mission file as read.

    Attributes:
        mission: as read.
        findings: faults of the file.
        source: its text.
        suffix: ".plan" or ".waypoints".
        planned: name of the NAME.json written with it, and its flight time [s].
        taken_for: reason for the autopilot of a `.waypoints` file that names none; "": the default one.
    """

    mission: Mission
    findings: tuple[Finding, ...]
    source: str
    suffix: str
    planned: tuple[str, float] | None = None
    taken_for: str | None = None

    def still_holds(self, mission: Mission) -> bool:
        """Compare all but the parameters."""
        ours, other = (replace(each, parameters={}) for each in (self.mission, mission))
        return repr(ours) == repr(other)  # repr: NaN equals NaN
