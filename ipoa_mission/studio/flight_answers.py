"""Messages on an open mission and its flight. Heights are meters above home."""

from typing import Literal

from ipoa_mission import Finding
from ipoa_mission.forecast.contingency.energy_budget import ReserveNow
from ipoa_mission.report.compare import LegTime
from ipoa_mission.studio.vocabulary import InFlight, LngLat, MapLine, Number, OfRevision, PageMessage


class Loaded(OfRevision, kind="loaded"):
    """The mission was read back equal. A start must name these values."""

    vehicle: str
    system: int
    mission: str
    proof: str
    items: int
    built_in: bool
    remarks: tuple[str, ...]


class OrderThen(PageMessage):
    """The effect of an order if given now; `clear` None: not checked."""

    what: InFlight
    clear: bool | None
    words: str
    seconds: Number


class Seen(PageMessage, kind="seen"):
    """The reported state; `expected_s`: estimate of the last item done. `said`: latest messages, newest first.

    `battery_left`: share of the charge; `reserve`: against the plan, if that is known.
    """

    time_s: float
    place: LngLat
    up: float
    speed: float
    done: int
    flown_s: Number
    expected_s: Number
    held: bool = False
    orders: tuple[OrderThen, ...] = ()
    battery_left: Number = None
    reserve: ReserveNow | None = None
    satellites: int | None = None
    wind: tuple[float, float] | None = None
    said: tuple[str, ...] = ()
    deviations: tuple[str, ...] = ()


class Landed(PageMessage, kind="landed"):
    """The flight is over; `ordered`: the order by which it landed."""

    completed: bool
    why_not: str
    ordered: Literal["rtl", "land"] | None = None
    flown_s: float
    estimated_s: float
    log: str


class State(PageMessage, kind="state"):
    """The flight's phase. `lost_s`: duration of a lost link [s]."""

    phase: Literal["idle", "uploading", "loaded", "preparing", "flying", "over"]
    words: str
    lost_s: Number = None


class HeardLink(PageMessage):
    link: str
    system: int | None
    words: str


class Heard(PageMessage, kind="heard"):
    links: tuple[HeardLink, ...]


class Replay(OfRevision, kind="replay"):
    log: str
    line: MapLine
    times: tuple[float, ...]
    items: tuple[LegTime, ...]
    estimated_s: float
    flown_s: Number
    remarks: tuple[str, ...]


class ItemField(PageMessage):
    """A label; `about`: MAVLink's description."""

    what: Literal["param1", "param2", "param3", "param4", "param5", "param6", "param7"]
    label: str
    unit: str
    about: str


class ItemKind(PageMessage):
    command: int
    name: str
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


class OpenMission(OfRevision, kind="mission"):
    """`worlds`: scenarios to check it in."""

    autopilot: str
    autopilots: tuple[str, ...]
    firmware: str
    scenario: str | None
    worlds: tuple[str, ...]
    items: tuple[MissionItem, ...]
    kinds: tuple[ItemKind, ...]
    lost: tuple[str, ...]


class Checked(OfRevision, kind="checked"):
    """Errors first; `timeless`: why there is no time estimate."""

    flaws: tuple[Finding, ...]
    timeless: str | None
    remarks: tuple[str, ...]
