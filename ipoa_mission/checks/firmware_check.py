"""Report content that a firmware refuses, changes silently, or cannot fly."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.autopilot.commands import (
    ENDINGS,
    FLOWN_TO,
    HOLDING,
    LAST_NAV,
    MAY_PRECEDE_TAKEOFF,
    TAKEOFFS,
    Command,
    Frame,
    command_name,
    plain_frame,
)
from ipoa_mission.autopilot.firmware_tables import Firmware, param_name
from ipoa_mission.autopilot.mav_types import NO_AIRCRAFT
from ipoa_mission.autopilot.parameters import SINGLE_MAX
from ipoa_mission.autopilot.version import Version
from ipoa_mission.checks.jump_check import check_jumps
from ipoa_mission.checks.numbered_finding import Numbered, numbered
from ipoa_mission.checks.positions import out_of_range
from ipoa_mission.checks.unsafe import refuse_errors
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.mission.fence_items import fence_to_wire, rally_to_wire
from ipoa_mission.mission.items import Item, Mission
from ipoa_mission.mission.stored_mission import to_wire, values_of

if TYPE_CHECKING:
    from ipoa_mission.scenario import Scenario

DEVELOPMENT = "dev"  # of a version


def check_firmware(mission: Mission) -> Iterator[Finding]:
    firmware = mission.autopilot.firmware(mission.firmware_version)
    is_development = mission.firmware_version is not None and mission.firmware_version.stage == DEVELOPMENT
    wire = to_wire(mission)
    yield from _limits(mission, firmware, len(wire))
    for at in numbered(mission):
        yield from _command_and_frame(at, mission.autopilot, firmware, is_development)
        yield from _params(at, firmware, mission)
    yield from check_jumps(mission)
    yield from check_waiting(mission)
    yield from _refused(mission, firmware, wire)
    if mission.vehicle_type not in NO_AIRCRAFT:
        yield from _takeoff(mission)
    yield from _ending(mission)
    yield from _terrain(mission)


def is_too_long(mission: Mission) -> bool:
    own = mission.autopilot.firmware(mission.firmware_version)
    return len(mission.items) + own.home_is_item_0 > own.max_items


def _limits(mission: Mission, firmware: Firmware, count: int) -> Iterator[Finding]:
    if not (mission.items or mission.fence or mission.rally):
        yield Finding("empty", Severity.ERROR, None, "the mission: expected at least one item, but there is none")
    counts = {
        "mission items": (count, firmware.max_items),
        "fence items (one for each vertex or circle)": (len(fence_to_wire(mission.fence)), firmware.max_fence_items),
        "rally points": (len(rally_to_wire(mission.rally)), firmware.max_rally_points),
    }
    for kind, (held, most) in counts.items():
        if held > most:
            message = f"the mission: expected at most {most} {kind} for {firmware.name}, not {held}"
            yield Finding("too-many", Severity.ERROR, None, message)


def _command_and_frame(
    at: Numbered, autopilot: Autopilot, firmware: Firmware, is_development: bool
) -> Iterator[Finding]:
    item, name = at.item, command_name(at.item.command)
    placed, plain = item.command in firmware.placed, item.command in firmware.plain
    if not placed and not plain:
        where = " in a mission: it belongs into the fence or rally list" if _is_fence(item, firmware) else ""
        words = f"{firmware} does not take {name}{where}"
        yield at.error("command-not-taken", words, _taken_later(item, autopilot, firmware))
    elif item.command in firmware.never_flown:
        yield at.error("command-never-flown", f"{firmware} stores {name}, and flies no mission that has it")
    elif is_development and not _before(autopilot, firmware).takes(item.command):
        yield at.warning("command-of-development", f"not every development version of {firmware} takes {name}")
    elif placed and item.frame not in firmware.frames:
        other = "an altitude above terrain" if item.frame in (10, 11) else f"frame {item.frame}"
        yield at.error("frame-not-taken", f"expected an altitude above home (frame 3) or AMSL (frame 0), not {other}")
    elif placed and not plain and item.frame == Frame.MISSION:
        message = "expected a frame with a position, not frame 2"
        if firmware.frame_2_is_amsl:
            yield at.warning("frame-without-place", f"{message}, which {firmware.name} takes for AMSL")
        else:
            yield at.error("frame-without-place", message)


def _before(autopilot: Autopilot, firmware: Firmware) -> Firmware:
    older = [series for series in autopilot.tables.series if series < firmware.version.series]
    return autopilot.firmware(Version(*older[-1])) if older else firmware


def _taken_later(item: Item, autopilot: Autopilot, firmware: Firmware) -> str | None:
    for series in autopilot.tables.series:
        if series > firmware.version.series and autopilot.firmware(Version(*series)).takes(item.command):
            return f"{firmware.name} {series[0]}.{series[1]} takes it"
    return None


def _refused(mission: Mission, firmware: Firmware, wire: Sequence[Item]) -> Iterator[Finding]:
    first = len(wire) - len(mission.items)
    for at, spoken in zip(numbered(mission), wire[first:], strict=True):
        wrong = mission.autopilot.refusals.mission(firmware, spoken.command, spoken.frame, values_of(spoken), len(wire))
        if wrong is None or not wrong.param or spoken.command == Command.DO_JUMP:
            continue  # reported elsewhere
        if wrong.param == 1 and spoken.command in HOLDING and math.isfinite(spoken.params[0]):
            continue
        is_place = wrong.param in (5, 6) and out_of_range(spoken.latitude_deg, spoken.longitude_deg)
        is_height = wrong.param == 7 and spoken.command in FLOWN_TO
        if at.item.frame == Frame.MISSION or not (is_place or is_height):
            words = f"{param_name(wrong.param)}: {wrong.words}: {firmware} refuses the mission"
            yield at.error("param-refused", words)
    for seq, item in enumerate(fence_to_wire(mission.fence)):
        wrong = mission.autopilot.refusals.fence(firmware, item.command, item.frame, values_of(item))
        if wrong is not None and wrong.words and wrong.result != "ERROR":  # `checks.fence` reports too few vertices
            words = f"fence item {seq}: {wrong.words}: {firmware} refuses the fence"
            yield Finding("fence-refused", Severity.ERROR, None, words)


def _is_fence(item: Item, firmware: Firmware) -> bool:
    return item.command in firmware.fence or item.command in firmware.rally


def _params(at: Numbered, firmware: Firmware, mission: Mission) -> Iterator[Finding]:
    item = at.item
    for n, value in enumerate(item.params, start=1):
        if abs(value) > SINGLE_MAX:
            words = f"param{n}: expected a number that fits in single precision, not {value:g}"
            yield at.error("param-too-large", words)
    hold = item.params[0]
    if item.command in HOLDING and math.isfinite(hold):
        if hold < 0:
            yield at.error("hold", f"param1: expected a hold of zero seconds or more, not {hold:g}")
        elif hold > firmware.longest_hold:
            yield at.error("hold", f"param1: expected a hold of at most {firmware.longest_hold:.0f} s, not {hold:g}")
        elif firmware.holds_whole_seconds and not hold.is_integer():
            words = f"param1: {firmware.name} holds for whole seconds: {int(hold)} s, not {hold:g}"
            yield at.warning("hold-rounded", words)
    if item.command in HOLDING and math.isnan(hold) and firmware.nan_holds:
        yield at.error("hold", f"param1: expected a hold in seconds, not NaN: {firmware.name} never ends it")
    if item.command == Command.DO_CHANGE_SPEED:
        too_fast = None if mission.other_vehicle else mission.autopilot.parameter_table.why_too_fast
        if not (item.params[1] > 0 or item.params[1] in (-1.0, -2.0)):
            yield at.error("speed", f"param2: expected a speed above zero, not {item.params[1]:g}")
        elif too_fast is not None and (why := too_fast(item.params[1], mission.parameters)):
            yield at.error("speed", f"param2: {why}")


def _takeoff(mission: Mission) -> Iterator[Finding]:
    moving = [at for at in _flown(mission) if at.item.command not in MAY_PRECEDE_TAKEOFF]
    if not moving:
        return
    first, guidance = moving[0], mission.autopilot.guidance
    if first.item.command not in TAKEOFFS:
        later = any(at.item.command in TAKEOFFS for at in moving)
        if guidance.needs_takeoff or later:
            words = f"expected the take-off first, not {command_name(first.item.command)}"
            yield first.error("takeoff-not-first", words)
        else:
            words = "the mission has no take-off: it is for a vehicle that already flies"
            yield first.warning("takeoff-missing", words)
    yield from _waits_armed(mission, first.seq)
    least = 0.0
    if guidance.least_takeoff is not None:
        name, more = guidance.least_takeoff
        least = mission.autopilot.parameter_table.moving[name] + more
    for at in moving:
        height = mission.altitude_above_home(at.item)
        if at.item.command in TAKEOFFS and height <= least:
            if guidance.own_takeoff > 0.0:
                climbs = f"{mission.autopilot.model} climbs {guidance.own_takeoff:g} m anyway"
                yield at.warning("takeoff-low", f"a take-off to {height:g} m above home: {climbs}")
            else:  # infeasible in PX4
                words = f"expected a take-off to more than {least:g} m above home, not to {height:g} m"
                yield at.error("takeoff-low", words)


def _flown(mission: Mission) -> list[Numbered]:
    return [at for at in numbered(mission) if at.item.command < Command.CONDITION_DELAY]


def _waits_armed(mission: Mission, takeoff: int) -> Iterator[Finding]:
    name = mission.autopilot.guidance.waits_armed
    if not name:
        return
    disarm_time = {**mission.autopilot.parameter_table.moving, **mission.parameters}[name]
    for at in numbered(mission)[: takeoff - 1]:
        if at.item.command == Command.NAV_DELAY and 0.0 < disarm_time <= at.item.params[0]:
            words = f"on the ground {mission.autopilot.model} disarms after {disarm_time:g} s ({name}; 0: never)"
            yield at.warning("disarms-waiting", words)


def _terrain(mission: Mission) -> Iterator[Finding]:
    over = [seq for seq, item in enumerate(mission.items, 1) if plain_frame(item.frame) == Frame.GLOBAL_TERRAIN_ALT]
    sensor = mission.autopilot.guidance.terrain_by
    if over and sensor and not mission.parameters.get(sensor):
        items = f"item{'s' if len(over) > 1 else ''} {', '.join(map(str, over))}"
        message = (
            f"{items}: above terrain: {mission.autopilot.model} arms only with terrain data, which a ground "
            f"station sends or its card holds, or with a range finder ({sensor})"
        )
        yield Finding("terrain-data", Severity.WARNING, over[0], message)


def _ending(mission: Mission) -> Iterator[Finding]:
    flown = _flown(mission)
    if flown and flown[-1].item.command not in ENDINGS | {Command.NAV_LOITER_UNLIM}:
        yield flown[-1].warning("ends-in-the-air", "the mission ends in the air, and the vehicle stays there")


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


NOT_MEASURED = "version-not-measured"
MEASURE_HINT = (
    "fly it in simulation first (docs/lab/flown.md), or go on with --unmeasured-version "
    "(in a scenario vehicle.unmeasured_version = true)"
)


def check_version(autopilot: Autopilot, version: Version | None, unmeasured: bool) -> Iterator[Finding]:
    """Report a version that was not measured, as an error unless `unmeasured`."""
    if (why := autopilot.not_measured(version)) is not None:
        yield _finding(why, unmeasured)


def expect_measured(scenario: "Scenario") -> None:
    """Raise Unsafe if the version was not measured, and not requested by `unmeasured_version`."""
    vehicle = scenario.vehicle
    refuse_errors(tuple(check_version(vehicle.autopilot, vehicle.version, vehicle.unmeasured_version)))


def check_aboard(
    mission: Mission, autopilot: Autopilot, reported: Version | None
) -> tuple[Mission, tuple[Finding, ...]]:
    """Return the mission with the reported version, and a finding if none is known."""
    aboard = replace(mission, autopilot=autopilot, firmware_version=reported or mission.firmware_version)
    if aboard.firmware_version is not None:
        return aboard, ()
    taken = autopilot.checked_for(None)
    why = f"the vehicle does not report its version: whether it was measured is unknown; {taken} is assumed"
    return aboard, (_finding(why, mission.unmeasured_version),)


def _finding(why: str, unmeasured: bool) -> Finding:
    severity = Severity.WARNING if unmeasured else Severity.ERROR
    return Finding("version-not-measured", severity, None, why, None if unmeasured else MEASURE_HINT)
