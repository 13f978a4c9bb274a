from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Field, TypeAdapter

from ipoa_mission.studio.vocabulary import InFlight, Json, LngLat, PageMessage, Path


class Put(PageMessage):
    """Set a value by its path, such as `vehicle.cruise_speed`; create tables on the way."""

    op: Literal["put"] = "put"
    path: Path
    value: Json


class Take(PageMessage):
    op: Literal["take"] = "take"
    path: Path


class Shift(PageMessage):
    op: Literal["shift"] = "shift"
    path: Path
    taken: LngLat
    put_down: LngLat


class Add(PageMessage):
    """Add a table to a list, with its place or corners."""

    op: Literal["add"] = "add"
    to: Literal["via", "rally", "obstacles", "fence", "maps"]
    table: dict[str, Json]
    place: LngLat | None = None
    ring: tuple[LngLat, ...] | None = None
    at: int | None = None


class DrawArea(PageMessage):
    """Draw an area, a hole in it, or a corridor by its middle line, which replaces all areas."""

    op: Literal["draw_area"] = "draw_area"
    what: Literal["area", "hole", "corridor"]
    ring: Annotated[tuple[LngLat, ...], Field(min_length=2)]


class OwnArea(PageMessage):
    """Draw the area in place of a map: polygons as rings, the outer one first."""

    op: Literal["own_area"] = "own_area"
    parts: tuple[tuple[tuple[LngLat, ...], ...], ...]


class MapArea(PageMessage):
    """Take the area from a map file; add a survey if there is none."""

    op: Literal["map_area"] = "map_area"
    file: str


class PutCorner(PageMessage):
    op: Literal["put_corner"] = "put_corner"
    path: Path
    place: LngLat


class AddCorner(PageMessage):
    """Insert a corner before the one at the path."""

    op: Literal["add_corner"] = "add_corner"
    path: Path
    place: LngLat


class PutItem(PageMessage):
    """None: the autopilot's default."""

    op: Literal["put_item"] = "put_item"
    seq: int
    what: Literal["command", "frame", "param1", "param2", "param3", "param4", "param5", "param6", "param7"]
    value: float | None


class MoveItem(PageMessage):
    op: Literal["move_item"] = "move_item"
    seq: int
    place: LngLat


class InsertItem(PageMessage):
    """Insert an item as number `seq`, at the height of the one before it."""

    op: Literal["insert_item"] = "insert_item"
    seq: int
    command: int
    place: LngLat | None = None


class TakeItem(PageMessage):
    op: Literal["take_item"] = "take_item"
    seq: int


class PlainItems(PageMessage):
    """Replace an item's survey or scan by plain items."""

    op: Literal["plain_items"] = "plain_items"
    seq: int


ItemChange: TypeAlias = PutItem | MoveItem | InsertItem | TakeItem | PlainItems
AreaChange: TypeAlias = DrawArea | OwnArea | MapArea | PutCorner | AddCorner
Change: TypeAlias = Annotated[Put | Take | Shift | Add | AreaChange | ItemChange, Field(discriminator="op")]


class Edit(PageMessage):
    """`seen`: the page's revision."""

    kind: Literal["edit"] = "edit"
    seen: int
    label: str
    changes: tuple[Change, ...]


class Rewrite(PageMessage):
    kind: Literal["rewrite"] = "rewrite"
    seen: int
    text: str


class Drag(PageMessage):
    """Sketch a change without making it; only the last request gets an answer."""

    kind: Literal["drag"] = "drag"
    number: int
    changes: tuple[Change, ...]


class SaveAs(PageMessage):
    """Write the mission next to its file, in the other format or under another name."""

    kind: Literal["save_as"] = "save_as"
    suffix: Literal[".plan", ".waypoints"]


class SetScenario(PageMessage):
    """Set what to check a mission with; None: no scenario, the file's autopilot."""

    kind: Literal["set_scenario"] = "set_scenario"
    scenario: str | None
    autopilot: str | None


class Open(PageMessage):
    kind: Literal["open"] = "open"
    path: str


class Begin(PageMessage):
    """Begin a new scenario at a written place and altitude [m AMSL]."""

    kind: Literal["begin"] = "begin"
    place: str
    altitude: Annotated[float, Field(ge=-450, le=9000)]


class Find(PageMessage):
    kind: Literal["find"] = "find"
    place: str


class Rest(PageMessage):
    """Plan the survey without the parts flown in these logs."""

    kind: Literal["rest"] = "rest"
    logs: tuple[str, ...]


class Do(PageMessage):
    """`take_theirs`: take another program's text. `detach`: write flight `flight` (from 0) as a mission of its own."""

    kind: Literal["do"] = "do"
    what: Literal["undo", "redo", "save", "save_over", "take_theirs", "plan", "cancel", "export", "abandon", "detach"]
    flight: Annotated[int, Field(ge=0)] = 0


class Upload(PageMessage):
    """Put the mission on a vehicle and read it back (first step). No link: the built-in autopilot.

    `set_params`: also write parameters. `flight`: from 0. `charged`: the user confirms a charged battery and that
    nobody is near the propellers; required on a link after another flight.
    """

    kind: Literal["upload"] = "upload"
    link: str | None = None
    system: int | None = None
    speedup: Annotated[float, Field(ge=0.1, le=1000)] = 1.0
    set_params: bool = False
    flight: Annotated[int, Field(ge=0)] = 0
    charged: bool = False


class Start(PageMessage):
    """Arm and fly (second step); refused if the values on the page differ."""

    kind: Literal["start"] = "start"
    vehicle: str
    mission: str
    proof: str


class Listen(PageMessage):
    kind: Literal["listen"] = "listen"
    link: str


class Order(PageMessage):
    kind: Literal["order"] = "order"
    what: InFlight


Request: TypeAlias = Annotated[
    Edit | Rewrite | Drag | Do | Rest | SaveAs | SetScenario | Open | Begin | Find | Upload | Start | Order | Listen,
    Field(discriminator="kind"),
]
REQUESTS: TypeAdapter[Any] = TypeAdapter(Request)
