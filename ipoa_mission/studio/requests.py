from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Field, TypeAdapter

from ipoa_mission.studio.vocabulary import InFlight, Json, LngLat, PageMessage, Path


class Put(PageMessage, op="put"):
    """Set a value by its path, such as `vehicle.cruise_speed`; create tables on the way."""

    path: Path
    value: Json


class Take(PageMessage, op="take"):
    path: Path


class Shift(PageMessage, op="shift"):
    path: Path
    taken: LngLat
    put_down: LngLat


class Add(PageMessage, op="add"):
    """Add a table to a list, with its place or corners."""

    to: Literal["via", "rally", "obstacles", "fence", "maps"]
    table: dict[str, Json]
    place: LngLat | None = None
    ring: tuple[LngLat, ...] | None = None
    at: int | None = None


class DrawArea(PageMessage, op="draw_area"):
    """Draw an area, a hole in it, or a corridor by its middle line, which replaces all areas."""

    what: Literal["area", "hole", "corridor"]
    ring: Annotated[tuple[LngLat, ...], Field(min_length=2)]


class OwnArea(PageMessage, op="own_area"):
    """Draw the area in place of a map: polygons as rings, the outer one first."""

    parts: tuple[tuple[tuple[LngLat, ...], ...], ...]


class MapArea(PageMessage, op="map_area"):
    """Take the area from a map file; add a survey if there is none."""

    file: str


class Corner(PageMessage):
    """Move a corner, or insert one before it."""

    op: Literal["put_corner", "add_corner"]
    path: Path
    place: LngLat


class PutItem(PageMessage, op="put_item"):
    """None: the autopilot's default."""

    seq: int
    what: Literal["command", "frame", "param1", "param2", "param3", "param4", "param5", "param6", "param7"]
    value: float | None


class MoveItem(PageMessage, op="move_item"):
    seq: int
    place: LngLat


class InsertItem(PageMessage, op="insert_item"):
    """Insert an item as number `seq`, at the height of the one before it."""

    seq: int
    command: int
    place: LngLat | None = None


class ItemStep(PageMessage):
    """Remove an item, or replace its survey or scan by plain items."""

    op: Literal["take_item", "plain_items"]
    seq: int


ItemChange: TypeAlias = PutItem | MoveItem | InsertItem | ItemStep
AreaChange: TypeAlias = DrawArea | OwnArea | MapArea | Corner
Change: TypeAlias = Annotated[Put | Take | Shift | Add | AreaChange | ItemChange, Field(discriminator="op")]


class Edit(PageMessage, kind="edit"):
    """`seen`: the page's revision."""

    seen: int
    label: str
    changes: tuple[Change, ...]


class Rewrite(PageMessage, kind="rewrite"):
    seen: int
    text: str


class Drag(PageMessage, kind="drag"):
    """Sketch a change without making it; only the last request gets an answer."""

    number: int
    changes: tuple[Change, ...]


class SaveAs(PageMessage, kind="save_as"):
    """Write the mission next to its file, in the other format or under another name."""

    suffix: Literal[".plan", ".waypoints"]


class SetScenario(PageMessage, kind="set_scenario"):
    """Set what to check a mission with; None: no scenario, the file's autopilot."""

    scenario: str | None
    autopilot: str | None


class Open(PageMessage, kind="open"):
    path: str


class Begin(PageMessage, kind="begin"):
    """Begin a new scenario at a written place and altitude [m AMSL]."""

    place: str
    altitude: Annotated[float, Field(ge=-450, le=9000)]


class Find(PageMessage, kind="find"):
    place: str


class Rest(PageMessage, kind="rest"):
    """Plan the survey without the parts flown in these logs."""

    logs: tuple[str, ...]


class Do(PageMessage, kind="do"):
    """`take_theirs`: take another program's text. `detach`: write flight `flight` (from 0) as a mission of its own."""

    what: Literal["undo", "redo", "save", "save_over", "take_theirs", "plan", "cancel", "export", "abandon", "detach"]
    flight: Annotated[int, Field(ge=0)] = 0


class Upload(PageMessage, kind="upload"):
    """Put the mission on a vehicle and read it back (first step). No link: the built-in autopilot.

    `set_params`: also write parameters. `flight`: from 0. `charged`: the user confirms a charged battery and that
    nobody is near the propellers; required on a link after another flight.
    """

    link: str | None = None
    system: int | None = None
    speedup: Annotated[float, Field(ge=0.1, le=1000)] = 1.0
    set_params: bool = False
    flight: Annotated[int, Field(ge=0)] = 0
    charged: bool = False


class Start(PageMessage, kind="start"):
    """Arm and fly (second step); refused if the values on the page differ."""

    vehicle: str
    mission: str
    proof: str


class Listen(PageMessage, kind="listen"):
    link: str


class Order(PageMessage, kind="order"):
    what: InFlight


Request: TypeAlias = Annotated[
    Edit | Rewrite | Drag | Do | Rest | SaveAs | SetScenario | Open | Begin | Find | Upload | Start | Order | Listen,
    Field(discriminator="kind"),
]
REQUESTS: TypeAdapter[Any] = TypeAdapter(Request)
