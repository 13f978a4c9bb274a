from collections.abc import Iterator

from ipoa_mission.checks.numbered_finding import item_of
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.forecast.deviation.law import not_measured
from ipoa_mission.forecast.deviation.promise import Kept, Promise
from ipoa_mission.mission.items import Mission

LIMIT_WORDS = {"obstacles": "to {}", "ground": "above the ground", "ceiling": "above the ground", "bounds": "inside {}"}


def check_clearance(mission: Mission, promise: Promise) -> Iterator[Finding]:
    """Report each limit that too few flights keep.

    It is a warning off the way, and where the scenario leaves less room. Contact is always an error.
    """
    scenario = promise.flight.scenario
    if promise.confidence is not None and (why := not_measured(mission.autopilot, scenario.wind.strongest)):
        yield Finding("wind-not-measured", Severity.WARNING, None, why)
    for kept in promise.broken:
        item = item_of(mission, kept.item)
        touches = kept.limit == "obstacles" and kept.kept < scenario.vehicle.radius
        report = item.error if kept.forbids or touches else item.warning
        yield report("flights-too-near", f"{_where(kept)}: {kept.words(promise.confidence)}")


def _where(kept: Kept) -> str:
    east, north, up = kept.place
    part = f"{kept.part}, " if kept.part else ""
    return f"{part}{LIMIT_WORDS[kept.limit].format(kept.to)} at east {east:.1f}, north {north:.1f}, up {up:.1f} m"
