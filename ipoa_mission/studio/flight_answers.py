"""What the server tells the page of a flight. Heights are metres above home."""

from typing import Literal

from ipoa_mission.studio.vocabulary import LngLat, Number, PageMessage


class Loaded(PageMessage):
    """The mission is on a vehicle and was read back equal; what a start must name."""

    kind: Literal["loaded"] = "loaded"
    revision: int
    vehicle: str
    mission: str
    proof: str
    items: int
    built_in: bool
    remarks: tuple[str, ...]


class EndingThen(PageMessage):
    """What an ending would do if it were ordered now; it takes so many seconds, if anybody knows."""

    ending: Literal["rtl", "land"]
    clear: bool
    words: str
    seconds: Number


class Seen(PageMessage):
    """Where the vehicle is, as it says; `expected_s` is when the estimate had the last item that is done."""

    kind: Literal["seen"] = "seen"
    time_s: float
    place: LngLat
    up: float
    speed: float
    done: int
    flown_s: Number
    expected_s: Number
    endings: tuple[EndingThen, ...] = ()


class Landed(PageMessage):
    """The flight is over."""

    kind: Literal["landed"] = "landed"
    completed: bool
    why_not: str
    flown_s: float
    estimated_s: float
    log: str


class State(PageMessage):
    """What the flight is at, in words; `phase` for what the page offers."""

    kind: Literal["state"] = "state"
    phase: Literal["idle", "uploading", "loaded", "preparing", "flying", "over"]
    words: str


class HeardLink(PageMessage):
    """A link, and who is heard on it; None: nobody, and why."""

    link: str
    system: int | None
    words: str


class Heard(PageMessage):
    """What was heard on all links."""

    kind: Literal["heard"] = "heard"
    links: tuple[HeardLink, ...]
