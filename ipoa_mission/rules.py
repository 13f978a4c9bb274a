"""The rules that a mission is checked by: what each means, what to do, and whether it may be ignored."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches

from ipoa_mission.errors import BadInput, UnknownName


@dataclass(frozen=True)
class Rule:
    """What it `means` when a mission breaks it, what to `do`; one from which a `crash` may follow is never ignored."""

    means: str
    do: str
    crash: bool


RULES: Mapping[str, Rule] = {
    "home-place": Rule("Home is no position on the Earth.", "Give it a latitude and a longitude in degrees.", True),
    "home-unknown": Rule(
        "Home is at latitude 0, longitude 0, which stands for no place.", "Set home where the vehicle takes off.", True
    ),
    "home-altitude": Rule(
        "Home's altitude is of no land on Earth.", "Give the altitude above mean sea level, in meters.", True
    ),
    "home-elsewhere": Rule(
        "The home in the file is far from the mission; the vehicle takes where it is armed instead.",
        "Set home where the vehicle takes off.",
        False,
    ),
    "home-differs": Rule(
        "The mission's home is not the scenario's: its heights above home are others there.",
        "Plan or check it with its own scenario.",
        True,
    ),
    "home-not-on-ground": Rule(
        "The ground at home is not as high as home's altitude: all heights are off by so much.",
        "Set home.altitude_amsl to the ground.",
        True,
    ),
    "another-place": Rule(
        "The mission and the scenario are of different places.", "Check it with its own scenario.", True
    ),
    "position-out-of-range": Rule("A latitude or longitude is none.", "Give degrees, -90 to 90 and -180 to 180.", True),
    "position-missing": Rule(
        "An item is at latitude 0, longitude 0, which stands for no place.", "Give it a place.", True
    ),
    "position-here": Rule(
        "An item names no place, and this autopilot carries it out where it is.",
        "Give it a place if that is not meant.",
        True,
    ),
    "too-far": Rule("An item is farther from home than anything flies: its position is wrong.", "Correct it.", True),
    "far": Rule(
        "An item is far from home.", "See that it is meant, and that the link and the battery reach so far.", False
    ),
    "altitude-missing": Rule("An altitude is no number.", "Give one in meters.", True),
    "altitude-kept": Rule(
        "An item has altitude 0, and this autopilot keeps its height there.",
        "Give it a height if that is not meant.",
        True,
    ),
    "height-over-terrain": Rule("A height over terrain makes no sense.", "Give one above 0, in meters.", True),
    "height-absurd": Rule(
        "A height above home makes no sense; often it is an altitude in the wrong frame.",
        "Correct the altitude or its frame.",
        True,
    ),
    "below-home": Rule(
        "An item lies below home, or as high as home.",
        "See that the ground is lower there, and that a height is given.",
        True,
    ),
    "empty": Rule("The mission holds nothing.", "Add an item.", False),
    "too-many": Rule(
        "The firmware holds fewer items, fence vertices or rally points.",
        "Split the mission, or take a wider spacing.",
        False,
    ),
    "command-not-taken": Rule(
        "The firmware, in this version, has no such command in a mission.",
        "Leave it out, or name another version by --firmware-version.",
        False,
    ),
    "command-never-flown": Rule(
        "The firmware stores the command, and then flies no mission that holds it.", "Leave it out.", False
    ),
    "command-of-development": Rule(
        "Not every development version takes the command.", "Fly it on a release that has it.", False
    ),
    "frame-not-taken": Rule(
        "The firmware does not take the altitude frame of an item.",
        "Give the altitude above home or above sea level.",
        True,
    ),
    "frame-without-place": Rule(
        "An item that needs a place is in the frame without one.",
        "Give it frame 3 (above home) or 0 (above sea level).",
        True,
    ),
    "param-refused": Rule(
        "The firmware refuses the value of a param, and with it the mission.", "Set it as the message says.", False
    ),
    "param-too-large": Rule("A param does not fit into the single precision of MAVLink.", "Give a smaller one.", False),
    "fence-refused": Rule(
        "The firmware refuses an item of the fence, and with it the fence.", "Set it as the message says.", False
    ),
    "hold": Rule("A hold is negative, too long, or without end.", "Give seconds, as the message says.", False),
    "hold-rounded": Rule("The firmware holds for whole seconds.", "Give whole seconds.", False),
    "speed": Rule(
        "DO_CHANGE_SPEED names no speed, or a greater one than the vehicle's limit.",
        "Give one above 0, in m/s, or the parameter that the message names.",
        False,
    ),
    "jump-target": Rule(
        "A DO_JUMP leads to no other item, or a DO_JUMP_TAG to a tag that no JUMP_TAG has.",
        "Give the number of an item, or the tag of a JUMP_TAG.",
        False,
    ),
    "jump-without-end": Rule(
        "A jump repeats for ever.", "Give a number of repeats, if someone is not to end it.", False
    ),
    "jump-repeats": Rule(
        "The firmware keeps no such number of repeats of a jump.",
        "Give a whole number, as the message says.",
        False,
    ),
    "jump-no-way-on": Rule(
        "Jumps lead to jumps until the firmware gives up.", "Put a waypoint into the loop, or remove a jump.", False
    ),
    "jump-flown-elsewhere": Rule(
        "ArduCopter flies on past a jump to a JUMP_TAG, or to another item that does not move it.",
        "Let DO_JUMP name the waypoint itself, or hold for a second before the jump.",
        True,
    ),
    "jump-tag-twice": Rule(
        "Two JUMP_TAG items have the same tag; jumps lead to the first.", "Give each a tag of its own.", False
    ),
    "too-many-jumps": Rule(
        "The mission has more jumps than the firmware counts, or a board with little memory.",
        "Write the passes out, or split the mission.",
        False,
    ),
    "waits-for-someone": Rule(
        "Other items follow a NAV_LOITER_UNLIM: the vehicle stays there until a pilot orders it on.",
        "Use NAV_LOITER_TIME, or end the mission with the NAV_LOITER_UNLIM.",
        False,
    ),
    "waits-until-clock": Rule(
        "NAV_DELAY waits until a time of day, which no estimate knows.",
        "Give the delay in seconds, if no time of day is meant.",
        False,
    ),
    "action-at-other-time": Rule(
        "At a jump, ArduPilot looks ahead for actions (camera, servo): one is done in another pass than listed.",
        "Put a waypoint between the jump and the item.",
        False,
    ),
    "takeoff-not-first": Rule(
        "Something that moves the vehicle comes before the take-off, or there is none.", "Begin with a take-off.", True
    ),
    "takeoff-missing": Rule(
        "The mission has no take-off: it serves a vehicle that already flies.",
        "Add one, if it is to begin on the ground.",
        False,
    ),
    "takeoff-low": Rule("A take-off is lower than this autopilot takes off to.", "Let it climb higher.", True),
    "disarms-waiting": Rule(
        "A delay before the take-off is longer than the vehicle stays armed.",
        "Shorten it, or change the parameter that is named.",
        False,
    ),
    "terrain-data": Rule(
        "Heights over terrain need terrain data or a range finder on the vehicle.",
        "Load them, or give heights above home.",
        False,
    ),
    "ends-in-the-air": Rule("The last item leaves the vehicle in the air.", "End with a landing or a return.", True),
    "rally-place": Rule("A rally point is no position, or far from home.", "Correct it.", True),
    "rally-height": Rule("A rally point has no height, or an absurd one.", "Give it above home, in meters.", True),
    "fence-place": Rule(
        "A corner of the fence is no position, or far from home, or a radius is none.", "Correct it.", True
    ),
    "fence-shape": Rule(
        "A part of the fence is no area.", "Give a polygon that does not cross itself, or a circle.", False
    ),
    "outside-fence": Rule(
        "Home, a rally point, or a leg lies outside of the fence.", "Widen the fence, or move what is named.", True
    ),
    "leg-too-near": Rule(
        "A leg comes nearer to something than the scenario allows, or leaves its bounds.",
        "Plan it, or move the waypoints; a hint says what helps a way home.",
        True,
    ),
    "flights-too-near": Rule(
        "Fewer flights than asked would keep the clearance, by how far this autopilot flies beside its path.",
        "Plan it, give it more room, or ask for less.",
        True,
    ),
    "return-too-near": Rule(
        "Ordered home on the way, the vehicle would come too near to something.",
        "Set the return altitude that the hint names.",
        True,
    ),
    "land-too-near": Rule(
        "A failsafe of the vehicle lands where it is, and there it would come down on something, or too near to it.",
        "Set the parameter that the hint names, so that it returns instead.",
        True,
    ),
    "battery-short": Rule(
        "The flight would land with less than the battery's reserve, or may empty it.",
        "Take the battery that the hint names, fly a shorter way or at another speed, or split the mission.",
        True,
    ),
    "battery-unsure": Rule(
        "One flight in twenty would land with less than the battery's reserve.",
        "Learn the vehicle from its logs, so that its energy is surer, or leave more.",
        False,
    ),
    "battery-no-return": Rule(
        "From some second on, an RTL would land with less than the battery's reserve, or not get home.",
        "Turn back before it, or have a rally point nearer; from there on it lands where it is.",
        True,
    ),
    "way-unknown": Rule(
        "An item moves the vehicle in a way that is not modeled: what it keeps of anything is not known.",
        "Leave the item out, or do what the hint says.",
        True,
    ),
    "never-reached": Rule("This firmware never gets to an item, and stays in the air.", "Do what the hint says.", True),
    "circle-sense": Rule(
        "The firmware circles the other way round than the item asks for.",
        "Turn the sign of the parameter that is named, or take the other sense.",
        False,
    ),
    "map-not-understood": Rule(
        "A leg leads over a thing of a map whose height nobody knows.",
        "Give its height, as the hint says, or fly round it.",
        True,
    ),
    "not-read": Rule(
        "A file holds something that may be an obstacle, a zone or another limit, and was not read.",
        "Do what the hint says. If it is none, ignore this code, by `--ignore` or by `safety.ignore`.",
        False,
    ),
    "fast-touchdown": Rule(
        "The vehicle touches down faster than it lands, on ground that is higher than home.",
        "Set the parameters that the hint names.",
        True,
    ),
    "slow-landing": Rule(
        "The last part of a landing is long and slow, on ground that is lower than home.",
        "A range finder shortens it.",
        False,
    ),
    "wind-too-strong": Rule(
        "The vehicle cannot fly the mission in this wind: it is pushed off its path, or does not get on.",
        "Fly in less wind, slower, or another way.",
        True,
    ),
    "wind-not-measured": Rule(
        "In this wind no flight was measured: what its flights keep is extrapolated.",
        "Fly in less wind, or keep more distance.",
        False,
    ),
    "version-not-measured": Rule(
        "Flights of this version of the firmware were not measured; with --unmeasured-version it is a warning.",
        "Take a version that was measured, or measure it in simulation (docs/lab/flown.md).",
        True,
    ),
    "waypoint-passed": Rule(
        "PX4 from 1.18 on may pass a waypoint at which the height changes, and fly on without end.",
        "Give the waypoint a hold of 0.1 s: the vehicle stops there and waits for its height.",
        True,
    ),
    "waypoint-may-be-passed": Rule(
        "PX4 from 1.18 on does not return to a waypoint that it passed without reaching it.",
        "Give each waypoint a hold of 0.1 s.",
        False,
    ),
    "no-aircraft": Rule("The mission is for a vehicle that does not fly.", "Only flights are judged.", False),
    "other-vehicle": Rule(
        "The mission is for another class of vehicle: its legs are judged as a multicopter flies them.",
        "Take nothing of its times or clearances for granted.",
        False,
    ),
    "file": Rule(
        "Something in the file is odd, and was read all the same.", "See the place that the message names.", False
    ),
    "file-unreadable": Rule(
        "The file cannot be read as a mission: nothing in it was checked.",
        "Mend the place that the message names.",
        True,
    ),
    "file-parameters": Rule(
        "Parameters beside the file are not read: some make no sense, or all are another autopilot's.",
        "Name those of the vehicle by --param-file.",
        True,
    ),
    "file-home": Rule(
        "The file has home at 0, 0, or not in frame 0: see what is taken for it.", "Give it a home.", False
    ),
    "file-other-list": Rule(
        "The file holds a fence or rally points, and no mission.", "Open the mission's file.", False
    ),
    "file-numbers": Rule(
        "The items are numbered with gaps; they are taken in their order.", "Number them anew.", False
    ),
}


def expect_ignorable(codes: Iterable[str]) -> frozenset[str]:
    """The codes, if each may be ignored.

    Raises:
        BadInput: one is none, or a crash may follow from what it finds.
    """
    for code in (codes := tuple(codes)):
        if code not in RULES:
            near = get_close_matches(code, RULES, 1)
            words = "expected the code of a finding"
            raise UnknownName(words, hint=f"did you mean {near[0]}?" if near else None, place=code)
        if RULES[code].crash:
            words = "expected a code that may be ignored: a crash may follow from what this one finds"
            raise BadInput(words, place=code)
    return frozenset(codes)
