"""What the server tells the page of a mission file that is open."""

from typing import Literal

from ipoa_mission.studio.vocabulary import LngLat, Number, PageMessage


class ItemField(PageMessage):
    """One of param1 to param7 of a command, in words; `about` is all that MAVLink says of it."""

    what: Literal["param1", "param2", "param3", "param4", "param5", "param6", "param7"]
    label: str
    unit: str
    about: str


class ItemKind(PageMessage):
    """A command that the firmware takes in a mission; `placed`: with a latitude, a longitude and a height."""

    command: int
    name: str
    placed: bool
    fields: tuple[ItemField, ...]


class MissionItem(PageMessage):
    """An item as its file has it: `values` are param1 to param7, None where the autopilot takes its own.

    `place` and `up` are of where it lies, if it lies somewhere; `part_of` the first and last item of the survey or scan
    that it is one of.
    """

    seq: int
    command: int
    words: str
    frame: int
    values: tuple[Number, ...]
    place: LngLat | None
    up: Number
    part_of: tuple[int, int] | None


class OpenMission(PageMessage):
    """A mission that is open, item by item; `worlds` are scenarios that it can be judged in, by their paths."""

    kind: Literal["mission"] = "mission"
    revision: int
    autopilot: str
    autopilots: tuple[str, ...]
    firmware: str
    scenario: str | None
    worlds: tuple[str, ...]
    items: tuple[MissionItem, ...]
    kinds: tuple[ItemKind, ...]
    lost: tuple[str, ...]


class Flaw(PageMessage):
    """What the check found, of an item or of none; an error keeps the mission on the ground."""

    severity: Literal["error", "warning"]
    seq: int | None
    words: str
    hint: str | None


class Checked(PageMessage):
    """What the check found of an open mission, errors first; `timeless`: why it has no time."""

    kind: Literal["checked"] = "checked"
    revision: int
    flaws: tuple[Flaw, ...]
    timeless: str | None
    remarks: tuple[str, ...]
