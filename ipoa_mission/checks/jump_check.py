"""Check jumps: targets, repeats, endless loops."""

import math
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace

from ipoa_mission.autopilot.commands import JUMPS, Command
from ipoa_mission.autopilot.guidance_profile import JumpProfile
from ipoa_mission.checks.numbered_finding import Numbered, item_of, numbered
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.forecast.itinerary.program import Steps, jump_target, program_of, tagged
from ipoa_mission.mission.items import Mission


def check_jumps(mission: Mission) -> Iterator[Finding]:
    jumps = [at for at in numbered(mission) if at.item.command in JUMPS]
    profile = mission.autopilot.firmware(mission.firmware_version).jumps
    found = [finding for at in jumps for finding in (*_target(mission, at), *_repeats(mission, at, profile))]
    yield from found
    yield from _tags(mission)
    yield from _too_many(mission, len(jumps), profile)
    if jumps and not any(finding.code == "jump-target" for finding in found):
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


def _target(mission: Mission, at: Numbered) -> Iterator[Finding]:
    target, count = at.item.params[0], len(mission.items)
    if at.item.command == Command.DO_JUMP_TAG:
        if jump_target(mission.items, at.seq - 1) is None:
            words = f"param1: expected the tag of a JUMP_TAG, not {target:g}"
            yield at.error("jump-target", f"{words}: {mission.autopilot.model} ends the mission here, in the air")
    elif not (math.isfinite(target) and float(target).is_integer() and 1 <= target <= count):
        yield at.error("jump-target", f"param1: expected the number of an item, 1 to {count}, not {target:g}")
    elif target == at.seq:
        yield at.error("jump-target", "param1: expected another item, not the jump itself")


def _repeats(mission: Mission, at: Numbered, profile: JumpProfile) -> Iterator[Finding]:
    asked, most = at.item.params[1], profile.most_repeats
    if asked == -1:
        words = f"param2: {asked:g} repeats never end: the mission flies until someone ends it"
        if not profile.repeats_without_end:
            words += f"; {mission.autopilot.model} stores no sign: its repeats of {asked:g} depend on the board"
        yield at.warning("jump-without-end", words)
    elif not (0 <= asked <= most and float(asked).is_integer()):
        yield at.error("jump-repeats", f"param2: expected a whole number of repeats from 0 to {most}, not {asked:g}")


def _tags(mission: Mission) -> Iterator[Finding]:
    for at in numbered(mission):
        if at.item.command == Command.JUMP_TAG and math.isfinite(tag := at.item.params[0]):
            first = next(tagged(mission.items, tag)) + 1
            if first != at.seq:
                yield at.warning("jump-tag-twice", f"item {first} has the tag {tag:g} too: jumps lead there")


def _too_many(mission: Mission, count: int, profile: JumpProfile) -> Iterator[Finding]:
    name = mission.autopilot.firmware(mission.firmware_version).name
    words = f"the mission: {count} jumps, and {name} takes"
    if count > profile.most:
        yield Finding("too-many-jumps", Severity.ERROR, None, f"{words} the first {profile.most} that it meets")
    elif count > profile.most_small:
        words = f"{words} the first {profile.most_small} that it meets on a board with less than 500 kB of memory"
        yield Finding("too-many-jumps", Severity.WARNING, None, words)


def _at_other_times(mission: Mission, flown: Steps, listed: Steps) -> Iterator[Finding]:
    done, due = _steps_of(flown), _steps_of(listed)
    for index in sorted(due):
        if done[index] == due[index] or mission.items[index].command == Command.JUMP_TAG:
            continue
        how = f"{len(done[index])} times, and the list has it {len(due[index])} times"
        jump = next((n + 1 for n in range(index, -1, -1) if mission.items[n].command in JUMPS), 0)
        if jump and done[index] and done[index][0] < due[index][0]:
            how = f"a pass of the jump at item {jump} early"
        yield item_of(mission, index + 1).warning("action-at-other-time", f"{mission.autopilot.model} runs it {how}")


def _steps_of(steps: Steps) -> defaultdict[int, list[int]]:
    found = defaultdict[int, list[int]](list)
    for number, (passed, at) in enumerate(steps):
        for index in passed if at is not None else ():
            found[index].append(number)
    return found
