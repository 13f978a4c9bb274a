from typing import Literal

from ipoa_mission.studio.vocabulary import LngLat, Number, PageMessage


class ItemField(PageMessage):
    """A label; `about`: MAVLink's description."""

    what: Literal["param1", "param2", "param3", "param4", "param5", "param6", "param7"]
    label: str
    unit: str
    about: str


class ItemKind(PageMessage):
    command: int
    name: str
    placed: bool
    fields: tuple[ItemField, ...]


class MissionItem(PageMessage):
    """`values`: param1 to param7, None for the default. `part_of`: first and last item of its survey or scan."""

    seq: int
    command: int
    words: str
    frame: int
    values: tuple[Number, ...]
    place: LngLat | None
    up: Number
    part_of: tuple[int, int] | None


class OpenMission(PageMessage):
    """`worlds`: scenarios to check it in."""

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
    """A finding; an error prevents the flight."""

    severity: Literal["error", "warning"]
    seq: int | None
    words: str
    hint: str | None


class Checked(PageMessage):
    """Errors first; `timeless`: why there is no time estimate."""

    kind: Literal["checked"] = "checked"
    revision: int
    flaws: tuple[Flaw, ...]
    timeless: str | None
    remarks: tuple[str, ...]
