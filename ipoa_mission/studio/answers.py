"""What the server tells the page. Heights are metres above home unless they say otherwise."""

from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Field, TypeAdapter

from ipoa_mission.studio.contingency_answers import StripOfEndings
from ipoa_mission.studio.flight_answers import Heard, Landed, Loaded, Replay, Seen, State
from ipoa_mission.studio.lobby_answers import Beginning, Elsewhere
from ipoa_mission.studio.mission_answers import Checked, OpenMission
from ipoa_mission.studio.requests import Change
from ipoa_mission.studio.survey_answers import CoarseSurvey, SurveyArea, SurveyLayout
from ipoa_mission.studio.vocabulary import LngLat, MapLine, Number, PageMessage, Path


class Document(PageMessage):
    """The file as it is now; of a scenario its table as the text has it, empty where it cannot be read."""

    kind: Literal["document"] = "document"
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
    """What may help, as a button: its words and the changes that it makes."""

    label: str
    changes: tuple[Change, ...]


class Fence(PageMessage):
    """A geofence that the scenario draws itself."""

    path: Path
    inclusion: bool
    ring: tuple[LngLat, ...]


class Trouble(PageMessage):
    """Something was not done; `of` says what it was of, `message` has one thing that is wrong on a line.

    `of_home`: whether one of them is wrong with home. `fences` are those that the text draws, where it makes no
    scenario.
    """

    kind: Literal["trouble"] = "trouble"
    of: Literal["edit", "scenario", "sketch", "plan", "file", "flight"]
    message: str
    of_home: bool = False
    hint: str | None = None
    revision: int | None = None
    remedies: tuple[Remedy, ...] = ()
    fences: tuple[Fence, ...] = ()


class Body(PageMessage):
    """An obstacle or a zone on the map; `path` where the scenario itself draws it. `rings`: outer one, then holes.

    `doubt`: a map has it, but not how high it is; a flight near it is refused.
    """

    name: str
    path: Path | None
    solid: bool
    doubt: bool = False
    base: float
    top: float
    rings: tuple[tuple[LngLat, ...], ...]


class Spot(PageMessage):
    """Home, start, goal, a via or a rally point."""

    name: str
    path: Path
    place: LngLat
    up: float
    above_ground: float


class Terrace(PageMessage):
    """Ground at least so high, as polygons: rings each, the outer one first."""

    up: float
    polygons: tuple[tuple[tuple[LngLat, ...], ...], ...]


class Tiles(PageMessage):
    """Map tiles for below the scenario; `address` has {z}, {x} and {y}, and is beside the page if it names no host.

    `vector`: they are no pictures, but things in `layers`, as far as their names are told.
    """

    kind: Literal["tiles"] = "tiles"
    address: str
    attribution: str
    min_zoom: int
    max_zoom: int
    vector: bool = False
    layers: tuple[str, ...] = ()


class Heights(PageMessage):
    """The ground on a grid, row by row from the south-west corner: `step` in degrees, `up` above home."""

    corner: LngLat
    step: LngLat
    columns: int
    up: tuple[float, ...]


class World(PageMessage):
    """What a map shows of a scenario; `box` is west, south, east, north of the flight's bounds.

    `degree_m` is how many metres a degree of longitude and one of latitude are at home.
    """

    kind: Literal["world"] = "world"
    revision: int
    box: tuple[float, float, float, float]
    around: tuple[LngLat, ...]
    degree_m: tuple[float, float]
    floor: float
    ceiling: float
    bodies: tuple[Body, ...]
    spots: tuple[Spot, ...]
    fences: tuple[Fence, ...]
    ground: tuple[Terrace, ...]
    heights: Heights
    home_amsl: float
    required: float
    remarks: tuple[str, ...]


class Sketch(PageMessage):
    """The coarse first answer: a path that is proved as it stands, or not, and other ways round; never the last word.

    `number` is that of the drag it answers, or None for the document.
    """

    kind: Literal["sketch"] = "sketch"
    revision: int
    number: int | None
    line: MapLine
    others: tuple[MapLine, ...]
    holds: bool
    verdict: str
    length: float
    clearance: float
    nearest: str
    seconds: float
    took_s: float


class Progress(PageMessage):
    """How far planning is."""

    kind: Literal["progress"] = "progress"
    revision: int
    share: float
    words: str


class Course(PageMessage):
    """The flight as predicted, sample by sample: time [s], distance over ground [m], speed [m/s], ground's height.

    `returns_at` is the sample at which it turns home, where it ends by a return.
    """

    line: MapLine
    times: tuple[float, ...]
    along: tuple[float, ...]
    speeds: tuple[float, ...]
    ground: tuple[float, ...]
    apart: tuple[Number, ...]
    returns_at: int | None


class Binding(PageMessage):
    """What holds the flight back at a place, and how: near something, or slow. `at` is the sample of the course."""

    what: Literal["near", "slow", "danger"]
    words: str
    at: int


class Beside(PageMessage):
    """An obstacle or a zone below or beside the course: between which distances along it, and its heights."""

    name: str
    look: Literal["below", "beside", "zone"]
    begins: float
    ends: float
    base: float
    top: float


class Stop(PageMessage):
    """An item of the mission as `show` numbers it, and the sample of the course at which it is done.

    `place`, `up` and `above_ground` are of where it lies, if it lies somewhere; `duration_s` is what it takes.
    """

    seq: int
    at: int
    words: str
    done_s: float
    duration_s: float
    place: LngLat | None
    up: Number
    above_ground: Number


class Choice(PageMessage):
    """A way to choose waypoints, and what it would come to."""

    mode: str
    waypoints: int
    seconds: float
    deviation: float
    flies_clear: bool
    chosen: bool


class Limit(PageMessage):
    """One limit that the proof looked at, in `unit`."""

    limit: str
    words: str
    found: float
    required: float
    unit: str
    holds: bool


class Homeward(PageMessage):
    """The way home if RTL were ordered at a time; of several that it may take the first."""

    from_s: float
    clear: bool
    line: MapLine


class Plan(PageMessage):
    """The proved answer; `warnings` are to be read before it is flown, `remarks` are what else is told.

    `proof` is a short digest of mission and promise, which a start must name. `of` a mission: the flight of an open
    one as expected, of which nothing is proved but what `kept` says.
    """

    kind: Literal["plan"] = "plan"
    of: Literal["scenario", "mission"] = "scenario"
    revision: int
    name: str
    proof: str
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
    tube_ring: tuple[tuple[LngLat, ...], ...]
    course: Course
    beside: tuple[Beside, ...]
    stops: tuple[Stop, ...]
    bindings: tuple[Binding, ...]
    homeward: tuple[Homeward, ...]
    choices: tuple[Choice, ...]
    limits: tuple[Limit, ...]
    warnings: tuple[str, ...]
    remarks: tuple[str, ...]
    took_s: float


class SurveyPart(PageMessage):
    """One flight of a survey: its file, how many lines and photos, and the flight itself as any other plan."""

    file: str
    lines: int
    photos: int
    plan: Plan


class PlannedSurvey(PageMessage):
    """The proved answer to a scenario with a survey: flight by flight, without what was `flown` by these logs."""

    kind: Literal["survey"] = "survey"
    revision: int
    layout: SurveyLayout
    flights: tuple[SurveyPart, ...]
    flown: tuple[str, ...]
    total_s: float
    energy_wh: Number
    took_s: float


class Found(PageMessage):
    """A place that was asked for, as it was written."""

    kind: Literal["found"] = "found"
    place: LngLat
    words: str


class Written(PageMessage):
    """Files that were written, and what their formats cannot hold."""

    kind: Literal["written"] = "written"
    files: tuple[str, ...]
    remarks: tuple[str, ...] = ()


Answer: TypeAlias = Annotated[
    Document
    | Trouble
    | World
    | Tiles
    | Sketch
    | Progress
    | Plan
    | SurveyArea
    | CoarseSurvey
    | PlannedSurvey
    | StripOfEndings
    | OpenMission
    | Checked
    | Beginning
    | Replay
    | Elsewhere
    | Found
    | Heard
    | Loaded
    | Seen
    | Landed
    | State
    | Written,
    Field(discriminator="kind"),
]
ANSWERS: TypeAdapter[Any] = TypeAdapter(Answer)
