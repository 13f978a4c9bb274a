"""The rules of `check`: meaning, advice, and whether a finding may be ignored."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches

from ipoa_mission.errors import BadInput, UnknownName


@dataclass(frozen=True)
class Rule:
    """A rule is never ignored if a `crash` may follow."""

    means: str
    do: str
    crash: bool


RULES: Mapping[str, Rule] = {
    "home-place": Rule("Home is not a position on the Earth.", "Give it a latitude and a longitude in degrees.", True),
    "home-unknown": Rule("Home is at latitude 0, longitude 0: it was not set.",
        "Set home where the vehicle takes off.", True),
    "home-altitude": Rule("Home's altitude is outside the range of land on Earth.",
        "Give the altitude above mean sea level, in meters.", True),
    "home-elsewhere": Rule(
        "The home in the file is far from the mission; the vehicle uses its place of arming instead.",
        "Set home where the vehicle takes off.", False),
    "home-differs": Rule("Heights above home count from the mission's, not the scenario's.",
        "Plan or check it with its own scenario.", True),
    "home-not-on-ground": Rule(
        "The ground at home differs from home's altitude: all heights are off by the difference.",
        "Set home.altitude_amsl to the ground.", True),
    "another-place": Rule("The mission and the scenario are of different places.",
        "Check it with its own scenario.", True),
    "position-out-of-range": Rule("A latitude or longitude is out of range.",
        "Give degrees, -90 to 90 and -180 to 180.", True),
    "position-missing": Rule("An item is at latitude 0, longitude 0: its position was not set.",
        "Give it a position.", True),
    "position-here": Rule("An item has no position, and this autopilot runs it at its current place.",
        "Give it a position.", True),
    "too-far": Rule("An item is beyond any flight from home: its position is wrong.", "Correct it.", True),
    "far": Rule("An item is far from home.", "Check that it is intended, and that link and battery reach it.", False),
    "altitude-missing": Rule("An altitude is not a number.", "Give one in meters.", True),
    "altitude-kept": Rule("An item has altitude 0, and this autopilot keeps its height there.",
        "Give it a height if that is not intended.", True),
    "height-over-terrain": Rule("A height over terrain is invalid.", "Give one above 0, in meters.", True),
    "height-absurd": Rule("A height above home is implausible; often it is an altitude in the wrong frame.",
        "Correct the altitude or its frame.", True),
    "below-home": Rule("An item is below home, or at its height.",
        "Check that the ground is lower there, and that a height is given.", True),
    "empty": Rule("The mission is empty.", "Add an item.", False),
    "too-many": Rule("The firmware stores fewer items, fence vertices or rally points.",
        "Split the mission, or use a wider spacing.", False),
    "command-not-taken": Rule("This version of the firmware does not support the command in a mission.",
        "Leave it out, or name another version by --firmware-version.", False),
    "command-never-flown": Rule("The firmware stores the command, and then flies no mission with it.",
        "Leave it out.", False),
    "command-of-development": Rule("Not every development version takes the command.",
        "Fly it on a release that has it.", False),
    "frame-not-taken": Rule("The firmware does not take the altitude frame of an item.",
        "Give the altitude above home or above sea level.", True),
    "frame-without-place": Rule("An item that needs a place is in the frame without one.",
        "Give it frame 3 (above home) or 0 (above sea level).", True),
    "param-refused": Rule("The firmware refuses a param, and with it the mission.",
        "Set it as the message says.", False),
    "param-too-large": Rule("A param exceeds the single precision of MAVLink.", "Give a smaller one.", False),
    "fence-refused": Rule("The firmware refuses an item of the fence, and with it the fence.",
        "Set it as the message says.", False),
    "hold": Rule("A hold is negative, too long, or without end.", "Give seconds, as the message says.", False),
    "hold-rounded": Rule("The firmware holds for whole seconds.", "Give whole seconds.", False),
    "speed": Rule("DO_CHANGE_SPEED has no speed, or one above the vehicle's limit.",
        "Give one above 0, in m/s, or the parameter that the message names.", False),
    "jump-target": Rule("A DO_JUMP leads to no other item, or a DO_JUMP_TAG to a tag that no JUMP_TAG has.",
        "Give the number of an item, or the tag of a JUMP_TAG.", False),
    "jump-without-end": Rule("A jump repeats without end.",
        "Give a number of repeats, unless an operator ends it.", False),
    "jump-repeats": Rule("The firmware does not store this number of repeats of a jump.",
        "Give a whole number, as the message says.", False),
    "jump-no-way-on": Rule("Jumps lead to jumps until the firmware gives up.",
        "Put a waypoint into the loop, or remove a jump.", False),
    "jump-flown-elsewhere": Rule(
        "ArduCopter flies past a jump to a JUMP_TAG, or to another item that does not move it.",
        "Let DO_JUMP name the waypoint itself, or hold for a second before the jump.", True),
    "jump-tag-twice": Rule("Two JUMP_TAG items have the same tag; jumps lead to the first.",
        "Give each a unique tag.", False),
    "too-many-jumps": Rule("The mission has more jumps than the firmware counts, or a board with little memory.",
        "Write out the passes, or split the mission.", False),
    "waits-for-someone": Rule(
        "Other items follow one at which the vehicle stays until a pilot resumes the mission.",
        "Use NAV_LOITER_TIME, switch autocontinue on, or end the mission there.", False),
    "behind-landing": Rule("Items follow a landing that ends the mission.", "Make two missions of it.", False),
    "fence-off": Rule("An item switches the fence off.", "Leave it out, unless the fence is not needed.", False),
    "waits-until-clock": Rule("NAV_DELAY waits until a time of day, which the estimate leaves out.",
        "Give the delay in seconds.", False),
    "action-at-other-time": Rule(
        "At a jump, ArduPilot looks ahead for actions (camera, servo): one runs in another pass than listed.",
        "Put a waypoint between the jump and the item.", False),
    "takeoff-not-first": Rule("An item moves the vehicle before the take-off, or there is no take-off.",
        "Begin with a take-off.", True),
    "takeoff-missing": Rule("The mission has no take-off: it is for a vehicle that already flies.",
        "Add one if it begins on the ground.", False),
    "ends-refused": Rule("MIS_TKO_LAND_REQ requires a take-off or landing that the mission lacks.",
        "Add it, or change the parameter.", False),
    "takeoff-low": Rule("A take-off is below the least height of this autopilot.", "Give a greater height.", True),
    "disarms-waiting": Rule("A delay before the take-off is longer than the vehicle stays armed.",
        "Shorten it, or change the named parameter.", False),
    "terrain-data": Rule("Heights over terrain need terrain data or a range finder on the vehicle.",
        "Load them, or give heights above home.", False),
    "terrain-clearance": Rule("Over uneven terrain the clearance of flights is unknown: only planned legs are judged.",
        "Give heights above home.", False),
    "ends-in-the-air": Rule("The last item leaves the vehicle in the air.", "End with a landing or a return.", True),
    "rally-place": Rule("A rally point is not a valid position, or far from home.", "Correct it.", True),
    "rally-height": Rule("A rally point has no height, or an implausible one.", "Give it above home, in meters.", True),
    "fence-place": Rule("A corner of the fence is not a valid position, or far from home, or a radius is invalid.",
        "Correct it.", True),
    "fence-shape": Rule("A part of the fence has no area.",
        "Give a polygon that does not cross itself, or a circle.", False),
    "outside-fence": Rule("Home, a rally point, or a leg is outside the fence.",
        "Widen the fence, or move the named item.", True),
    "leg-too-near": Rule("A leg is nearer to an obstacle or the ground than the scenario allows, or leaves its bounds.",
        "Plan it, or move the waypoints; for a way home see the hint.", True),
    "flights-too-near": Rule("Fewer flights than required keep the clearance.",
        "Plan it, give it more room, or require less.", True),
    "return-too-near": Rule("An RTL on the way would come too near to an obstacle or the ground.",
        "Set the return altitude in the hint.", True),
    "land-too-near": Rule("A failsafe of the vehicle lands in place: on an obstacle, or too near to it.",
        "Set the parameter in the hint, so that it returns instead.", True),
    "battery-short": Rule("The flight would land with less than the battery's reserve, or may empty it.",
        "Use the battery in the hint, fly a shorter way or at another speed, or split the mission.", True),
    "battery-unsure": Rule("One flight in twenty would land with less than the battery's reserve.",
        "Learn the vehicle from its logs to narrow its energy, or leave more.", False),
    "battery-no-return": Rule(
        "From some time on, an RTL would land with less than the battery's reserve, or not get home.",
        "Turn back before that time, or add a nearer rally point; after it the vehicle lands in place.", True),
    "way-unknown": Rule("An item moves the vehicle in a way that is not modeled: its clearance is unknown.",
        "Leave the item out, or follow the hint.", True),
    "never-reached": Rule("This firmware never reaches an item, and stays in the air.", "Follow the hint.", True),
    "circle-sense": Rule("The firmware circles in the other direction than the item.",
        "Change the sign of the named parameter, or the direction of the item.", False),
    "map-not-understood": Rule("A leg leads over a map feature of unknown height.",
        "Give its height, as in the hint, or fly around it.", True),
    "not-read": Rule("A file has content that may be an obstacle, a zone or another limit, and was not read.",
        "Follow the hint. If it limits nothing, ignore this code with `--ignore` or `safety.ignore`.", False),
    "readers-differ": Rule("GDAL finds other shapes in a map.", "Compare both readings, and correct the file.", False),
    "fast-touchdown": Rule("The vehicle touches down above its landing speed, on ground that is higher than home.",
        "Set the parameters in the hint.", True),
    "slow-landing": Rule("The last part of a landing is long and slow, on ground that is lower than home.",
        "A range finder shortens it.", False),
    "wind-too-strong": Rule(
        "The vehicle cannot fly the mission in this wind: it leaves its path, or makes no progress.",
        "Fly in less wind, slower, or on another path.", True),
    "wind-not-measured": Rule("No flight was measured in this wind: the clearance is extrapolated.",
        "Fly in less wind, or keep more distance.", False),
    "version-not-measured": Rule(
        "Flights of this version of the firmware were not measured; with --unmeasured-version it is a warning.",
        "Use a version that was measured, or measure it in simulation (docs/lab/flown.md).", True),
    "waypoint-passed": Rule("PX4 from 1.18 on may pass a waypoint at which the height changes, and fly on without end.",
        "Give the waypoint a hold of 0.1 s: the vehicle stops there and waits for its height.", True),
    "waypoint-may-be-passed": Rule("PX4 from 1.18 on does not return to a waypoint that it passed without reaching it.",
        "Give each waypoint a hold of 0.1 s.", False),
    "no-aircraft": Rule("The mission is for a vehicle that does not fly.", "Only flights are checked.", False),
    "other-vehicle": Rule(
        "The mission is for another class of vehicle: its legs are checked as those of a multicopter.",
        "Do not rely on its times or clearances.", False),
    "file": Rule("The file has irregular content, which was read.", "See the place in the message.", False),
    "file-unreadable": Rule("The file cannot be read as a mission: nothing in it was checked.",
        "Correct the place in the message.", True),
    "file-parameters": Rule(
        "The parameters next to the file are not read: some are invalid, or all are another autopilot's.",
        "Give the vehicle's parameters with --param-file.", True),
    "file-home": Rule("The file has home at 0, 0, or not in frame 0: see the home used instead.",
        "Give it a home.", False),
    "file-numbers": Rule("The item numbers have gaps; the items are read in order.", "Renumber them.", False),
}  # fmt: skip


def expect_ignorable(codes: Iterable[str]) -> frozenset[str]:
    """Raise BadInput if a code is unknown, or a crash may follow from its finding."""
    chosen = tuple(codes)
    for code in chosen:
        if code not in RULES:
            near = get_close_matches(code, RULES, 1)
            words = "expected the code of a finding"
            raise UnknownName(words, hint=f"did you mean {near[0]}?" if near else None, place=code)
        if RULES[code].crash:
            words = "expected a code that may be ignored: a crash may follow from this finding"
            raise BadInput(words, place=code)
    return frozenset(chosen)
