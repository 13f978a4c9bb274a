"""Check a mission against the tables of its firmware: items that it refuses, changes silently, or cannot fly."""

import math
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import replace

from ipoa_mission.autopilot.autopilot import NO_AIRCRAFT, Autopilot
from ipoa_mission.autopilot.commands import FLOWN_TO, HOLDING, LANDINGS, Command, Frame
from ipoa_mission.autopilot.firmware_tables import PARAM_NAMES, Firmware
from ipoa_mission.autopilot.guidance_profile import JumpProfile
from ipoa_mission.autopilot.parameters import SINGLE_MAX
from ipoa_mission.autopilot.version import Version
from ipoa_mission.errors import BadInput, Remedy
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.forecast.itinerary.copter_curves import circle_turn
from ipoa_mission.forecast.itinerary.itinerary import LONGEST_HOLD
from ipoa_mission.mission.item_words import count_words, name_items
from ipoa_mission.mission.items import Item, Mission, Numbered, item_of, numbered_items
from ipoa_mission.mission.positions import out_of_range
from ipoa_mission.mission.program import (
    Steps,
    as_flown,
    behind_landing,
    items_tagged,
    jump_target,
    program_of,
    stays_at,
)
from ipoa_mission.mission.stored_mission import fence_to_wire, to_wire, values_of


def check_firmware(mission: Mission) -> Iterator[Finding]:
    firmware = mission.firmware
    wire = to_wire(mission)
    yield from _limits(mission, firmware, len(wire))
    for at in numbered_items(mission):
        yield from _command_and_frame(at, firmware, mission)
        yield from _params(at, firmware, mission)
    yield from _jumps(mission)
    yield from _waits(mission)
    yield from _refused(mission, firmware, wire)
    if mission.vehicle_type not in NO_AIRCRAFT:
        yield from _takeoff(mission)
    flown = [at for at in numbered_items(mission) if at.item.command < Command.CONDITION_DELAY]
    if flown and flown[-1].item.command not in LANDINGS | {Command.NAV_LOITER_UNLIM}:
        yield flown[-1].warning("ends-in-the-air", "the mission ends in the air, and the vehicle stays there")
    behind = behind_landing(mission)
    if behind is not None:
        landing, after = behind
        words = f"{mission.autopilot.model} ends the mission at the {landing.item.name} of item {landing.seq}"
        yield after.warning("behind-landing", f"{words}; the forecast flies on")
    yield from _terrain(mission)


def is_too_long(mission: Mission) -> bool:
    firmware = mission.firmware
    return len(mission.items) + firmware.home_is_item_0 > firmware.max_items


def _limits(mission: Mission, firmware: Firmware, count: int) -> Iterator[Finding]:
    if not (mission.items or mission.fence or mission.rally):
        yield Finding("empty", Severity.ERROR, None, "the mission: expected at least one item, but there is none")
    counts = {
        "mission items": (count, firmware.max_items),
        "fence items (one for each vertex or circle)": (len(fence_to_wire(mission.fence)), firmware.max_fence_items),
        "rally points": (len(mission.rally), firmware.max_rally_points),
    }
    for kind, (actual, most) in counts.items():
        if actual > most:
            message = f"the mission: expected at most {most} {kind} for {firmware.name}, not {actual}"
            yield Finding("too-many", Severity.ERROR, None, message)


def _command_and_frame(at: Numbered, firmware: Firmware, mission: Mission) -> Iterator[Finding]:
    item = at.item
    autopilot = mission.autopilot
    is_development = mission.firmware_version is not None and mission.firmware_version.stage == "dev"
    older = [series for series in autopilot.tables.series if series < firmware.version.series]
    has_place = item.command in firmware.placed
    has_none = item.command in firmware.plain
    if not has_place and not has_none:
        is_of_a_fence = item.command in firmware.fence or item.command in firmware.rally
        where = " in a mission: it belongs into the fence or rally list" if is_of_a_fence else ""
        newer = (series for series in autopilot.tables.series if series > firmware.version.series)
        takers = (series for series in newer if autopilot.firmware(Version(*series)).takes(item.command))
        hint = next((f"{firmware.name} {major}.{minor} takes it" for major, minor in takers), None)
        yield at.error("command-not-taken", f"{firmware} does not take {item.name}{where}", hint)
    elif item.command in firmware.never_flown:
        yield at.error("command-never-flown", f"{firmware} stores {item.name}, and flies no mission that has it")
    elif is_development and older and not autopilot.firmware(Version(*older[-1])).takes(item.command):
        yield at.warning("command-of-development", f"not every development version of {firmware} takes {item.name}")
    elif has_place and item.frame not in firmware.frames:
        frame = "an altitude above terrain" if item.is_over_terrain else f"frame {item.frame}"
        yield at.error("frame-not-taken", f"expected an altitude above home (frame 3) or AMSL (frame 0), not {frame}")
    elif has_place and not has_none and item.frame == Frame.MISSION:
        message = "expected a frame with a position, not frame 2"
        if firmware.frame_2_is_amsl:
            yield at.warning("frame-without-place", f"{message}, which {firmware.name} takes for AMSL")
        else:
            yield at.error("frame-without-place", message)


def _refused(mission: Mission, firmware: Firmware, wire: Sequence[Item]) -> Iterator[Finding]:
    first = len(wire) - len(mission.items)
    for at, spoken in zip(numbered_items(mission), wire[first:], strict=True):
        wrong = mission.autopilot.refusals.mission(firmware, spoken.command, spoken.frame, values_of(spoken), len(wire))
        if wrong is None or not wrong.param or spoken.command == Command.DO_JUMP:
            continue  # reported elsewhere
        if wrong.param == 1 and spoken.command in HOLDING and not math.isnan(spoken.params[0]):
            continue
        is_place = wrong.param in (5, 6) and out_of_range(spoken.latitude_deg, spoken.longitude_deg)
        is_height = wrong.param == 7 and spoken.command in FLOWN_TO
        if at.item.frame == Frame.MISSION or not (is_place or is_height):
            words = f"{PARAM_NAMES[wrong.param - 1]}: {wrong.words}: {firmware} refuses the mission"
            yield at.error("param-refused", words)
    for seq, item in enumerate(fence_to_wire(mission.fence), 1):
        wrong = mission.autopilot.refusals.fence(firmware, item.command, item.frame, values_of(item))
        if wrong is not None and wrong.words and wrong.result != "ERROR":  # `checks.fence` reports too few vertices
            words = f"fence item {seq}: {wrong.words}: {firmware} refuses the fence"
            yield Finding("fence-refused", Severity.ERROR, None, words)
    commands = {item.command for item in mission.items}
    wrong = mission.autopilot.refusals.ends(commands, mission.parameters)
    if wrong is not None and commands and not mission.other_vehicle:
        words = f"the mission: {firmware} refuses it by MIS_TKO_LAND_REQ: {wrong.words}"
        hint = "add the item, for which an RTL is no landing, or change the parameter in the vehicle"
        remedies = () if Command.NAV_LAND in commands else (Remedy(("route", "ending"), "land"),)
        yield Finding("ends-refused", Severity.ERROR, None, words, hint, remedies)


def _params(at: Numbered, firmware: Firmware, mission: Mission) -> Iterator[Finding]:
    item = at.item
    for n, value in enumerate(item.params, start=1):
        if abs(value) > SINGLE_MAX:
            words = f"param{n}: expected a number that fits in single precision, not {value:g}"
            yield at.error("param-too-large", words)
    hold = item.params[0]
    longest = min(firmware.longest_hold if item.command in HOLDING else math.inf, LONGEST_HOLD)
    if item.hold_s > longest:
        yield at.error("hold", f"param1: expected a hold of at most {longest:.0f} s, not {hold:g}")
    elif item.command in HOLDING and not math.isnan(hold):
        if hold < 0:
            yield at.error("hold", f"param1: expected a hold of zero seconds or more, not {hold:g}")
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
    guidance = mission.autopilot.guidance
    moving = [at for at in numbered_items(mission) if not guidance.may_precede_takeoff(at.item.command)]
    if not moving:
        return
    first = moving[0]
    parameters = mission.complete_parameters
    if not first.item.is_takeoff:
        lands = first.item.command == Command.NAV_LAND
        if guidance.needs_takeoff or lands or any(at.item.is_takeoff for at in moving):
            yield first.error("takeoff-not-first", f"expected the take-off first, not {first.item.name}")
        else:
            words = "the mission has no take-off: it is for a vehicle that already flies"
            yield first.warning("takeoff-missing", words)
    if name := guidance.waits_armed:
        disarm_time = parameters[name]
        for at in numbered_items(mission)[: first.seq - 1]:
            if at.item.command == Command.NAV_DELAY and 0.0 < disarm_time <= at.item.params[0]:
                words = f"on the ground {mission.autopilot.model} disarms after {disarm_time:g} s ({name}; 0: never)"
                yield at.warning("disarms-waiting", words)
    within = guidance.takeoff_done_within
    for at in (at for at in moving if at.item.is_takeoff):
        height = mission.altitude_above_home(at.item)
        words = f"a take-off to {height:g} m above home: {mission.autopilot.model}"
        if height <= 0.0 and guidance.own_takeoff > 0.0:
            yield at.warning("takeoff-low", f"{words} climbs {guidance.own_takeoff:g} m anyway")
        elif height <= 0.0:
            yield at.error("takeoff-low", f"{words} refuses the mission")
        elif within and height <= parameters[within] + 1.0:  # [m], error of home's height
            below = f"{parameters[within]:g} m ({within}) below"
            yield at.warning("takeoff-low", f"{words} may leave for the next item {below}, near the ground")


def _terrain(mission: Mission) -> Iterator[Finding]:
    over = [seq for seq, item in enumerate(mission.items, 1) if item.is_over_terrain]
    sensor = mission.autopilot.guidance.terrain_by
    if over and sensor and not mission.parameters.get(sensor):
        arms = f"{mission.autopilot.model} arms only with terrain data, which a ground station sends or its card holds"
        words = f"{name_items(over)}: above terrain: {arms}, or with a range finder ({sensor})"
        yield Finding("terrain-data", Severity.WARNING, over[0], words)


def _waits(mission: Mission) -> Iterator[Finding]:
    for at in stays_at(mission):
        why = "" if at.item.autocontinue else "its autocontinue is off: "
        words = f"{why}stays here until an operator goes on: the time and the clearance of its flights are unknown"
        yield at.warning("waits-for-someone", words)
    for at in numbered_items(mission):
        if until := at.item.clock:
            if mission.autopilot.guidance.waits_until_clock:
                words = f"waits until {until}, which may be up to a day: the forecast time leaves it out"
                yield at.warning("waits-until-clock", words)
            elif any(value > 0 for value in at.item.params[1:]):
                words = f"{mission.autopilot.model} has no delay until {until}, and does not wait"
                yield at.warning("waits-until-clock", words)


def check_version(autopilot: Autopilot, version: Version | None, unmeasured: bool) -> Iterator[Finding]:
    if (why := autopilot.not_measured(version)) is not None:
        yield _not_measured(why, unmeasured)


def check_aboard(
    mission: Mission, autopilot: Autopilot, reported: Version | None
) -> tuple[Mission, tuple[Finding, ...]]:
    """Return the mission with the reported version, and a finding if none is known."""
    aboard = replace(mission, autopilot=autopilot, firmware_version=reported or mission.firmware_version)
    if aboard.firmware_version is not None:
        return aboard, ()
    assumed = autopilot.checked_for(None)
    why = f"the vehicle does not report its version: whether it was measured is unknown; {assumed} is assumed"
    return aboard, (_not_measured(why, mission.unmeasured_version),)


def _not_measured(why: str, is_allowed: bool) -> Finding:
    if is_allowed:
        return Finding("version-not-measured", Severity.WARNING, None, why)
    allow = "--unmeasured-version (in a scenario vehicle.unmeasured_version = true)"
    hint = f"fly it in simulation first (docs/lab/flown.md), or go on with {allow}"
    return Finding("version-not-measured", Severity.ERROR, None, why, hint)


def _jumps(mission: Mission) -> Iterator[Finding]:
    jumps = [at for at in numbered_items(mission) if at.item.is_jump]
    profile = mission.firmware.jumps
    findings = [finding for at in jumps for finding in (*_jump_target(mission, at), *_repeats(mission, at, profile))]
    yield from findings
    yield from _tags(mission)
    yield from _too_many(mission, len(jumps), profile)
    if jumps and not any(finding.code == "jump-target" for finding in findings):
        program = program_of(mission, mission.items)
        in_turn = replace(program, jumping=replace(program.jump_profile, queues_actions=False), jumped={})
        flown, _ = program.followed()
        if program.stuck_at is not None:
            words = (
                f"from here jumps lead to jumps, or to items that do not move the vehicle: {mission.autopilot.model} "
                "stays there in the air"
            )
            yield item_of(mission, program.stuck_at + 1).error("jump-no-way-on", words)
        else:
            yield from _at_other_times(mission, flown, in_turn.followed()[0])


def _jump_target(mission: Mission, at: Numbered) -> Iterator[Finding]:
    target = at.item.params[0]
    count = len(mission.items)
    if at.item.command == Command.DO_JUMP_TAG:
        if jump_target(mission.items, at.seq - 1) is None:
            words = f"param1: expected the tag of a JUMP_TAG, not {target:g}"
            yield at.error("jump-target", f"{words}: {mission.autopilot.model} ends the mission here, in the air")
    elif not (math.isfinite(target) and float(target).is_integer() and 1 <= target <= count):
        yield at.error("jump-target", f"param1: expected the number of an item, 1 to {count}, not {target:g}")
    elif target == at.seq:
        yield at.error("jump-target", "param1: expected another item, not the jump itself")


def _repeats(mission: Mission, at: Numbered, profile: JumpProfile) -> Iterator[Finding]:
    count = at.item.params[1]
    most = profile.most_repeats
    if count == -1:
        words = f"param2: {count:g} repeats never end: the mission flies until someone ends it"
        if not profile.repeats_without_end:
            words += f"; {mission.autopilot.model} stores no sign: its repeats of {count:g} depend on the board"
        yield at.warning("jump-without-end", words)
    elif not (0 <= count <= most and float(count).is_integer()):
        yield at.error("jump-repeats", f"param2: expected a whole number of repeats from 0 to {most}, not {count:g}")


def _tags(mission: Mission) -> Iterator[Finding]:
    for at in numbered_items(mission):
        if at.item.command == Command.JUMP_TAG and math.isfinite(tag := at.item.params[0]):
            first = next(items_tagged(mission.items, tag)) + 1
            if first != at.seq:
                yield at.warning("jump-tag-twice", f"item {first} has the tag {tag:g} too: jumps lead there")


def _too_many(mission: Mission, count: int, profile: JumpProfile) -> Iterator[Finding]:
    words = f"the mission: {count} jumps, and {mission.firmware.name} takes"
    if count > profile.most:
        yield Finding("too-many-jumps", Severity.ERROR, None, f"{words} the first {profile.most} that it meets")
    elif count > profile.most_small:
        words = f"{words} the first {profile.most_small} that it meets on a board with less than 500 kB of memory"
        yield Finding("too-many-jumps", Severity.WARNING, None, words)


def _at_other_times(mission: Mission, flown: Steps, listed: Steps) -> Iterator[Finding]:
    done = _steps_by_item(flown)
    due = _steps_by_item(listed)
    for index in sorted(due):
        if done[index] == due[index] or mission.items[index].command == Command.JUMP_TAG:
            continue
        how = f"{count_words(len(done[index]), 'time')}, and the list has it {count_words(len(due[index]), 'time')}"
        jump = next((n + 1 for n in range(index, -1, -1) if mission.items[n].is_jump), 0)
        if jump and done[index] and done[index][0] < due[index][0]:
            how = f"a pass of the jump at item {jump} early"
        yield item_of(mission, index + 1).warning("action-at-other-time", f"{mission.autopilot.model} runs it {how}")


def _steps_by_item(steps: Steps) -> defaultdict[int, list[int]]:
    numbers = defaultdict[int, list[int]](list)
    for number, (passed, at) in enumerate(steps):
        if at is not None:
            for index in passed:
                numbers[index].append(number)
    return numbers


def check_known_path(forecast: Forecast) -> Iterator[Finding]:
    mission = forecast.mission_as_read
    firmware = mission.firmware
    for unknown in forecast.unknown:
        at = item_of(mission, unknown.seq)
        words = f"{unknown.why}; the clearance is unknown"
        if not firmware.takes(at.item.command) or at.item.command in firmware.never_flown:
            continue
        match unknown.code:
            case "jump-flown-elsewhere":
                yield at.error("jump-flown-elsewhere", words, unknown.hint)
            case "never-reached":
                yield at.error("never-reached", words, unknown.hint)
            case _:
                yield at.error("way-unknown", words, unknown.hint)
    parameters = mission.complete_parameters
    for at in numbered_items(mission):
        radius = at.item.params[2]
        if at.item.command != Command.NAV_LOITER_TURNS or radius == 0.0 or not math.isfinite(radius):
            continue
        turn = circle_turn(at.item)
        flown = mission.autopilot.circle(parameters, abs(radius), turn, None, mission.firmware_version)
        if flown is not None and flown.sense * radius < 0.0:
            sense = "clockwise" if flown.sense > 0.0 else "counterclockwise"
            words = f"{firmware} flies it {sense}: the sign of CIRCLE_RATE counts, and that of the radius does not"
            yield at.warning("circle-sense", words)


def check_passing(forecast: Forecast) -> Iterator[Finding]:
    """Report an error for waypoints without a hold before a change of height, and a warning for all others.

    PX4 from 1.18 on moves its vertical setpoint separately: it oscillates, and does not return to a passed waypoint.
    """
    mission = forecast.mission
    hold = mission.autopilot.waypoint_defaults(mission.firmware_version).hold
    if hold == 0.0:
        return
    rises = _rises(forecast)
    climbing = [seq for seq, rise in rises.items() if not rise <= 0.001]  # [m] of PX4
    level = [seq for seq in rises if seq not in climbing]
    hint = f"give each a hold of {hold:g} s (param1): the vehicle stops there and waits for its height"
    if climbing:
        words = f"{name_items(climbing)}: {mission.firmware} may pass at another height, and fly on without end"
        yield Finding("waypoint-passed", Severity.ERROR, climbing[0], words, hint)
    if level:
        words = f"{name_items(level)}: {mission.firmware} does not return to a waypoint that it passed"
        yield Finding("waypoint-may-be-passed", Severity.WARNING, level[0], words, hint)


def _rises(forecast: Forecast) -> dict[int, float]:
    mission = forecast.mission
    try:
        program = forecast.itinerary.program
        seqs = [visit.seq for visit in forecast.itinerary.visits]
    except BadInput:
        program = program_of(mission, as_flown(mission).items)
        seqs = list(range(1, len(mission.items) + 1))
    rises: dict[int, float] = {}
    for n, (seq, item) in enumerate(zip(seqs, program.items, strict=True)):
        if item.is_waypoint and not item.params[0] > 0.0 and (onward := program.onward(n)) is not None:
            rises[seq] = max(abs(float(program.places[onward, 2] - program.places[n, 2])), rises.get(seq, 0.0))
    return dict(sorted(rises.items()))
