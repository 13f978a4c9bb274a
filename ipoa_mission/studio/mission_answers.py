"""Define the server's messages on an open mission file."""

from typing import Literal

from ipoa_mission.studio.vocabulary import LngLat, Number, PageMessage


class ItemField(PageMessage):
    """The label of one of param1 to param7; `about` is MAVLink's full description."""

    what: Literal["param1", "param2", "param3", "param4", "param5", "param6", "param7"]
    label: str
    unit: str
    about: str


class ItemKind(PageMessage):
    """A command that the firmware takes in a mission; `placed`: with latitude, longitude and height."""

    command: int
    name: str
    placed: bool
    fields: tuple[ItemField, ...]


class MissionItem(PageMessage):
    """An item as in its file: `values` are param1 to param7, None for the autopilot's default.

    `place` and `up` are None for an item without a position; `part_of` is the first and last item of its survey or
    scan.
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
    """An open mission; `worlds` are the paths of scenarios to check it in."""

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
    """A finding of the check, of an item or of none; an error prevents the flight."""

    severity: Literal["error", "warning"]
    seq: int | None
    words: str
    hint: str | None


class Checked(PageMessage):
    """The findings of the check, errors first; `timeless`: why there is no time estimate."""

    kind: Literal["checked"] = "checked"
    revision: int
    flaws: tuple[Flaw, ...]
    timeless: str | None
    remarks: tuple[str, ...]
