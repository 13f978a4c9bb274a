"""Check items at which a mission waits for an operator or for a time of day."""

from collections.abc import Iterator

from ipoa_mission.checks.numbered_finding import numbered
from ipoa_mission.finding import Finding
from ipoa_mission.mission.commands import LAST_NAV, Command
from ipoa_mission.mission.items import Mission


def check_waiting(mission: Mission) -> Iterator[Finding]:
    last = max((at.seq for at in numbered(mission) if at.item.command <= LAST_NAV), default=0)
    for at in numbered(mission):
        if at.item.command == Command.NAV_LOITER_UNLIM and at.seq < last:
            words = "stays here until an operator ends it: the time and the clearance of its flights are unknown"
            yield at.warning("waits-for-someone", words)
        if until := at.item.clock:
            if mission.autopilot.guidance.waits_until_clock:
                words = f"waits until {until}, which may be up to a day: the forecast time leaves it out"
                yield at.warning("waits-until-clock", words)
            elif any(value > 0 for value in at.item.params[1:]):
                words = f"{mission.autopilot.model} has no delay until {until}, and does not wait"
                yield at.warning("waits-until-clock", words)
