"""Keys of a `.plan`, unread or missing, and numbers."""

import json
import math
import re
from collections.abc import Iterator
from enum import IntEnum

from ipoa_mission.autopilot.commands import Frame
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.mission.json_node import Node
from ipoa_mission.unread import Unread, gathered


class AltitudeMode(IntEnum):
    """QGroundControl's; with CALCULATED, `Altitude` is over the ground and `AMSLAltAboveTerrain` is flown."""

    MIXED = 0
    RELATIVE = 1
    AMSL = 2
    CALCULATED = 3
    TERRAIN = 4


ALTITUDE_MODES = {
    Frame.GLOBAL_RELATIVE_ALT: AltitudeMode.RELATIVE,
    Frame.GLOBAL: AltitudeMode.AMSL,
    Frame.GLOBAL_TERRAIN_ALT: AltitudeMode.TERRAIN,
}


def tidy(value: float) -> float | int | None:
    """As QGroundControl: whole numbers without a point, NaN as null."""
    if not math.isfinite(value):
        return None
    return int(value) if abs(value) < 1e15 and value == int(value) else value


#: `[]`: of each member of a list; keys without effect on a flight are listed too.
KEYS = {
    "": {"fileType", "version", "groundStation", "mission", "geoFence", "rallyPoints", "landingGround", "UUID"},
    "landingGround": {"aboveHome", "latitude", "longitude"},
    "mission": {
        *("version", "firmwareType", "vehicleType", "plannedHomePosition", "items"),
        *("cruiseSpeed", "hoverSpeed", "globalPlanAltitudeMode"),
    },
    "mission.items[]": {
        *("type", "command", "frame", "params", "coordinate", "autoContinue", "doJumpId", "MISSION_ITEM_ID"),
        *("Altitude", "AltitudeMode", "AMSLAltAboveTerrain"),
    },
    "geoFence": {"version", "polygons", "circles", "breachReturn"},
    "geoFence.polygons[]": {"polygon", "inclusion", "version"},
    "geoFence.circles[]": {"circle", "inclusion", "version"},
    "geoFence.circles[].circle": {"center", "radius"},
    "rallyPoints": {"version", "points"},
}
#: QGroundControl always writes these; the assumption without.
EXPECTED = {
    "geoFence": "taken as a mission without a fence",
    "geoFence.polygons": "taken as a fence without polygons",
    "geoFence.circles": "taken as a fence without circles",
    "rallyPoints": "taken as a mission without rally points",
    "rallyPoints.points": "taken as a mission without rally points",
    "mission.vehicleType": "taken as a multicopter",
}


def findings_of_keys(plan: Node) -> Iterator[Finding]:
    """Report unread keys; those that may limit a flight as errors."""
    missing = {place for place in EXPECTED if _lacks(plan, place)}
    for unread in gathered(_unread(plan, missing)):
        words = unread.words.removeprefix(f"{unread.file}: ")
        if unread.may_limit:
            yield Finding("not-read", Severity.ERROR, None, words, unread.remedy)
        else:
            yield Finding("file", Severity.WARNING, None, words)
    for place in sorted(missing):
        yield Finding("file", Severity.WARNING, None, f"{place}: missing: {EXPECTED[place]}")


def _lacks(plan: Node, place: str) -> bool:
    parent, _, key = place.rpartition(".")
    above = plan.value.get(parent) if parent else plan.value
    return isinstance(above, dict) and key not in above and "polygon" not in above  # version 1


def _unread(node: Node, missing: set[str]) -> Iterator[Unread]:
    if isinstance(node.value, list):
        for child in node.array():
            yield from _unread(child, missing)
    elif isinstance(node.value, dict):
        kind = re.sub(r"\[\d+\]", "[]", node.place)
        known = KEYS.get(kind)
        if known is None or node.value.get("type") == "ComplexItem":
            return
        if kind == "mission.items[]" and "params" not in node.value:  # version 1
            known = known | {f"param{n}" for n in range(1, 5)}
        for key, value in node.value.items():
            if key in known:
                yield from _unread(node[key], missing)
            elif value not in (None, "", [], {}):
                may_limit = (
                    kind.startswith(("geoFence", "rallyPoints"))
                    or re.search("fence|rally|zone|polygon|circle|clusion", key, re.IGNORECASE)
                    or (not kind and missing & {"geoFence", "rallyPoints"})
                )
                remedy = "spell it as QGroundControl does, or ignore this code where it limits no flight"
                name, place = f'key "{key}"', node.place or "the file"
                yield Unread(node.file, name, place, json.dumps(value), may_limit=bool(may_limit), remedy=remedy)
