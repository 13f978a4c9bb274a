"""What the server tells the page of a flight. Heights are metres above home."""

from typing import Literal

from ipoa_mission.studio.vocabulary import InFlight, LngLat, MapLine, Number, PageMessage


class Loaded(PageMessage):
    """The mission is on a vehicle and was read back equal; what a start must name."""

    kind: Literal["loaded"] = "loaded"
    revision: int
    vehicle: str
    system: int
    mission: str
    proof: str
    items: int
    built_in: bool
    remarks: tuple[str, ...]


class OrderThen(PageMessage):
    """What an order would do if it were given now; it takes so many seconds, if anybody knows.

    `clear`: None where nobody has looked.
    """

    what: InFlight
    clear: bool | None
    words: str
    seconds: Number


class Reserve(PageMessage):
    """The battery by the vehicle's own word, as shares: `left` now, and `planned` to be left now.

    It lands with `lands`, between `least` and `most`, where `required` must be left; None where nothing is planned.
    """

    left: float
    planned: Number = None
    lands: Number = None
    least: Number = None
    most: Number = None
    required: Number = None


class Seen(PageMessage):
    """Where the vehicle is, as it says; `expected_s` is when the estimate had the last item that is done.

    `held`: it holds its place; `said`: what it has said lately, the last words first; `deviations`: from the forecast.
    """

    kind: Literal["seen"] = "seen"
    time_s: float
    place: LngLat
    up: float
    speed: float
    done: int
    flown_s: Number
    expected_s: Number
    held: bool = False
    orders: tuple[OrderThen, ...] = ()
    reserve: Reserve | None = None
    satellites: int | None = None
    wind: tuple[float, float] | None = None
    said: tuple[str, ...] = ()
    deviations: tuple[str, ...] = ()


class Landed(PageMessage):
    """The flight is over; `ordered`: the order of the page by which it landed."""

    kind: Literal["landed"] = "landed"
    completed: bool
    why_not: str
    ordered: Literal["rtl", "land"] | None = None
    flown_s: float
    estimated_s: float
    log: str


class State(PageMessage):
    """What the flight is at, in words; `phase` for what the page offers. `lost_s`: so long the link is lost [s]."""

    kind: Literal["state"] = "state"
    phase: Literal["idle", "uploading", "loaded", "preparing", "flying", "over"]
    words: str
    lost_s: Number = None


class HeardLink(PageMessage):
    """A link, and who is heard on it; None: nobody, and why."""

    link: str
    system: int | None
    words: str


class Heard(PageMessage):
    """What was heard on all links."""

    kind: Literal["heard"] = "heard"
    links: tuple[HeardLink, ...]


class FlownItem(PageMessage):
    """An item of a flight in a log: how long since the one before it was to take, and took, and when it was done."""

    seq: int
    estimated_s: float
    flown_s: float
    done_s: float


class Replay(PageMessage):
    """A flight in a log beside the estimate of the mission: where it went, and item by item."""

    kind: Literal["replay"] = "replay"
    revision: int
    log: str
    line: MapLine
    times: tuple[float, ...]
    items: tuple[FlownItem, ...]
    estimated_s: float
    flown_s: Number
    remarks: tuple[str, ...]
