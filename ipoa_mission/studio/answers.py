"""Messages to the page. Heights are meters above home unless noted."""

from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Field, TypeAdapter

from ipoa_mission.report.panels.contingency_panel import GradeLook
from ipoa_mission.report.panels.profile import NearbyObstacle
from ipoa_mission.studio.flight_answers import Checked, Heard, Landed, Loaded, OpenMission, Replay, Seen, State
from ipoa_mission.studio.requests import Change
from ipoa_mission.studio.vocabulary import LngLat, MapLine, Number, OfRevision, PageMessage, Path

#: rings, the outer one first
Polygons: TypeAlias = tuple[tuple[tuple[LngLat, ...], ...], ...]


class StripStretch(PageMessage):
    """A stretch with one outcome; distances along [m]. `words`: destination, share kept and required."""

    look: GradeLook
    from_s: float
    to_s: float
    begins: float
    ends: float
    words: str


class StripCost(PageMessage):
    """Time [s] and energy [Wh], each at least and at most; landing share of the battery, None without one."""

    at_s: float
    seconds: tuple[float, float]
    energy_wh: tuple[float, float] | None
    lands: Number
    least: Number
    most: Number


class StripBar(PageMessage):
    """Interpolate between `costs`."""

    contingency: str
    stretches: tuple[StripStretch, ...]
    costs: tuple[StripCost, ...]


class ContingencyStrip(OfRevision, kind="contingencies"):
    """Outcomes of one flight of a survey (from 0), first without `costs`; `reserve`: share that must be left."""

    flight: int
    reserve: Number
    bars: tuple[StripBar, ...]


class Beginning(PageMessage, kind="beginning"):
    """Paths of scenarios, missions and logs."""

    folder: str
    here: tuple[str, ...]
    examples: tuple[str, ...]


class Redirect(PageMessage, kind="redirect"):
    address: str


class Document(PageMessage, kind="document"):
    """The open file. `scenario`: its table, empty where the text cannot be read."""

    of: Literal["scenario", "mission"] = "scenario"
    revision: int
    name: str
    path: str
    text: str
    scenario: dict[str, Any]
    unsaved: bool
    changed_outside: bool
    undo: str | None
    redo: str | None


class Remedy(PageMessage):
    label: str
    changes: tuple[Change, ...]


class Fence(PageMessage):
    path: Path
    inclusion: bool
    ring: tuple[LngLat, ...]


class Trouble(PageMessage, kind="trouble"):
    """A failed step `of` the server; `message` has one error a line. `fences`: drawn from an invalid text."""

    of: Literal["edit", "scenario", "sketch", "plan", "file", "flight"]
    message: str
    of_home: bool = False
    hint: str | None = None
    revision: int | None = None
    remedies: tuple[Remedy, ...] = ()
    fences: tuple[Fence, ...] = ()


class Body(PageMessage):
    """`rings`: outer one, then holes; `doubt`: its height is unknown, flights near it are refused."""

    name: str
    path: Path | None
    solid: bool
    doubt: bool = False
    base: float
    top: float
    rings: tuple[tuple[LngLat, ...], ...]


class Spot(PageMessage):
    name: str
    path: Path
    place: LngLat
    up: float
    above_ground: float


class Terrace(PageMessage):
    """Ground at least at `up` [m]: polygons as rings, the outer one first."""

    up: float
    polygons: Polygons


class Tiles(PageMessage, kind="tiles"):
    """Map tiles of a server; `address` has {z}, {x} and {y}."""

    address: str
    attribution: str
    max_zoom: int
    vector: bool = False


class Heights(PageMessage):
    """The ground row by row from the south-west corner: `step` [deg], `up` above home [m]."""

    corner: LngLat
    step: LngLat
    columns: int
    up: tuple[float, ...]


class World(OfRevision, kind="world"):
    """`box`: west, south, east, north of the bounds. `degree_m`: meters per degree of longitude and latitude."""

    box: tuple[float, float, float, float]
    around: tuple[LngLat, ...]
    degree_m: tuple[float, float]
    floor: float = 0.0
    ceiling: float = 500.0
    bodies: tuple[Body, ...] = ()
    spots: tuple[Spot, ...]
    fences: tuple[Fence, ...]
    ground: tuple[Terrace, ...] = ()
    heights: Heights
    home_amsl: float
    required: float = 0.0
    remarks: tuple[str, ...] = ()


class Sketch(OfRevision, kind="sketch"):
    """A coarse first path; `others`: other ways round. `number`: of the drag it answers, None for the document."""

    number: int | None
    line: MapLine
    others: tuple[MapLine, ...]
    is_proved: bool
    verdict: str
    length: float
    clearance: float
    nearest: str
    seconds: float


class Progress(OfRevision, kind="progress"):
    share: float
    words: str


class Course(PageMessage):
    """Samples of the predicted flight: time [s], distance over ground [m], speed [m/s], ground height [m]."""

    line: MapLine
    times: tuple[float, ...]
    along: tuple[float, ...]
    speeds: tuple[float, ...]
    ground: tuple[float, ...]
    apart: tuple[Number, ...]
    returns_at: int | None


class Binding(PageMessage):
    """A constraint that binds at sample `at`."""

    what: Literal["near", "slow", "danger"]
    words: str
    at: int


class Stop(PageMessage):
    """An item, numbered as by `show`, and the sample at which it is done; None: without a position."""

    seq: int
    at: int
    words: str
    done_s: float
    place: LngLat | None
    up: Number
    above_ground: Number


class Limit(PageMessage):
    limit: str
    words: str
    is_kept: bool


class Homeward(PageMessage):
    """The return path if RTL is ordered from `from_s` on; the first of several."""

    from_s: float
    clear: bool
    line: MapLine


class Plan(OfRevision, kind="plan"):
    """The proved plan; of a mission only `kept` is proved.

    `warnings` matter before the flight. `proof`: digest of mission and guarantee, which a start must name.
    """

    of: Literal["scenario", "mission"] = "mission"
    name: str
    proof: str = ""
    verdict: str
    confidence: Number
    kept: Number
    nominal: Number
    required: float
    nearest: str
    total_s: float
    low_s: float
    high_s: float
    length: float
    energy_wh: Number
    battery_left: Number
    deviation_ring: tuple[tuple[LngLat, ...], ...]
    course: Course
    nearby: tuple[NearbyObstacle, ...]
    stops: tuple[Stop, ...]
    bindings: tuple[Binding, ...]
    homeward: tuple[Homeward, ...]
    waypoints: int | None = None
    limits: tuple[Limit, ...] = ()
    warnings: tuple[str, ...] = ()
    remarks: tuple[str, ...]


class AreaRing(PageMessage):
    """An open ring of the area, or a corridor's middle line; `path` if the scenario draws it."""

    name: str
    path: Path | None
    what: Literal["outer", "hole", "line"]
    places: tuple[LngLat, ...]


class SurveyArea(OfRevision, kind="area"):
    """The area as in the file, valid or not; no rings without a survey."""

    rings: tuple[AreaRing, ...]
    cameras: tuple[str, ...]


class SurveyLine(PageMessage):
    """A line: its flight (from 0), heights of its ends, photos."""

    flight: int
    begin: LngLat
    end: LngLat
    up: tuple[float, float]
    photos: tuple[LngLat, ...]


class LeastOverlap(PageMessage):
    share: float
    place: LngLat


class SurveyLayout(PageMessage):
    """Lines, connections and coverage: `share` of the visible area that is seen, and its `gaps`.

    `height`: least and most above the highest ground seen. `footprint`: of a photo across and along, or the sensor's
    width. `trigger`: largest distance of photos. `front` and `side`: smallest overlaps.
    `short`: photos with too little overlap, in words. `degrees`: of the longest line.
    """

    lines: tuple[SurveyLine, ...]
    ways: tuple[tuple[LngLat, ...], ...]
    seen: Polygons
    gaps: Polygons
    kept_out: Polygons
    share: float
    gaps_m2: float
    area_m2: float
    spacing: float
    trigger: Number
    photos: int
    height: tuple[float, float]
    footprint: tuple[float, float]
    front: LeastOverlap | None
    side: LeastOverlap | None
    short: tuple[str, ...]
    degrees: float


class CoarseSurvey(OfRevision, kind="coarse_survey"):
    """Unproved lines; `seconds` without take-off, transit and landing; `number` of the drag it answers."""

    number: int | None
    layout: SurveyLayout
    seconds: float


class SurveyPart(PageMessage):
    file: str
    lines: int
    photos: int
    plan: Plan


class PlannedSurvey(OfRevision, kind="survey"):
    """The proved flights, without the parts already `flown` in these logs."""

    layout: SurveyLayout
    flights: tuple[SurveyPart, ...]
    flown: tuple[str, ...]
    total_s: float
    energy_wh: Number


class Found(PageMessage, kind="found"):
    place: LngLat
    words: str


class Written(PageMessage, kind="written"):
    """Files written; `remarks` name what their formats cannot hold."""

    files: tuple[str, ...]
    remarks: tuple[str, ...] = ()


OfDocument: TypeAlias = Document | Trouble | World | Tiles | Sketch | Progress | Plan
OfMission: TypeAlias = SurveyArea | CoarseSurvey | PlannedSurvey | ContingencyStrip | OpenMission | Checked
OfFlight: TypeAlias = Beginning | Replay | Redirect | Found | Heard | Loaded | Seen | Landed | State | Written
Answer: TypeAlias = Annotated[OfDocument | OfMission | OfFlight, Field(discriminator="kind")]
ANSWERS: TypeAdapter[Any] = TypeAdapter(Answer)
