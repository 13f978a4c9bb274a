"""Items at which a mission waits for what it does not hold itself: for somebody, or for a time of day."""

from collections.abc import Iterator

from ipoa_mission.checks.numbered_finding import numbered
from ipoa_mission.finding import Finding
from ipoa_mission.mission.commands import LAST_NAV, Command
from ipoa_mission.mission.items import Mission


def check_waiting(mission: Mission) -> Iterator[Finding]:
    """Findings about NAV_LOITER_UNLIM before other items, and about NAV_DELAY until a time of day."""
    last = max((at.seq for at in numbered(mission) if at.item.command <= LAST_NAV), default=0)
    for at in numbered(mission):
        if at.item.command == Command.NAV_LOITER_UNLIM and at.seq < last:
            words = "stays here until someone ends it: no time, and no clearance of its flights, is known"
            yield at.warning("waits-for-someone", words)
        if until := at.item.clock:
            if mission.autopilot.guidance.waits_until_clock:
                words = f"waits until {until}, which may be up to a day: the times leave that out"
                yield at.warning("waits-until-clock", words)
            elif any(value > 0 for value in at.item.params[1:]):
                words = f"{mission.autopilot.model} knows no delay until {until}, and does not wait"
                yield at.warning("waits-until-clock", words)
