"""What the page asks of the server, and the changes of a scenario that it asks for."""

from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Field, TypeAdapter

from ipoa_mission.studio.vocabulary import InFlight, Json, LngLat, PageMessage, Path


class Put(PageMessage):
    """A value of the scenario by its path, such as `vehicle.cruise_speed`; tables on the way are made."""

    op: Literal["put"] = "put"
    path: Path
    value: Json


class Take(PageMessage):
    """A value or a table is taken out."""

    op: Literal["take"] = "take"
    path: Path


class Shift(PageMessage):
    """What lies at a path is moved as if it were taken at one place of the map and put down at the other."""

    op: Literal["shift"] = "shift"
    path: Path
    taken: LngLat
    put_down: LngLat


class Add(PageMessage):
    """A table joins a list of the scenario, with its place or its corners on the map."""

    op: Literal["add"] = "add"
    to: Literal["via", "rally", "obstacles", "fence", "maps"]
    table: dict[str, Json]
    place: LngLat | None = None
    ring: tuple[LngLat, ...] | None = None
    at: int | None = None


class DrawArea(PageMessage):
    """An area joins the survey, or is the first of a new one in place of start, goal and via; or a hole, a corridor.

    A hole goes into the area that it begins in; a corridor, whose middle is the `ring`, takes the place of all areas.
    """

    op: Literal["draw_area"] = "draw_area"
    what: Literal["area", "hole", "corridor"]
    ring: Annotated[tuple[LngLat, ...], Field(min_length=2)]


class OwnArea(PageMessage):
    """The survey's area is drawn in the scenario itself, no more in a map: polygons as rings, the outer one first."""

    op: Literal["own_area"] = "own_area"
    parts: tuple[tuple[tuple[LngLat, ...], ...], ...]


class MapArea(PageMessage):
    """The survey's area is that of a map which lies beside the scenario; without a survey there is one from now on."""

    op: Literal["map_area"] = "map_area"
    file: str


class PutCorner(PageMessage):
    """A corner of the survey's area goes elsewhere, by its path."""

    op: Literal["put_corner"] = "put_corner"
    path: Path
    place: LngLat


class AddCorner(PageMessage):
    """A corner of the survey's area is put in where its path says, before the one that is there."""

    op: Literal["add_corner"] = "add_corner"
    path: Path
    place: LngLat


class PutItem(PageMessage):
    """One value of a mission's item: its command, frame, param1 to param7; None: the autopilot's own."""

    op: Literal["put_item"] = "put_item"
    seq: int
    what: Literal["command", "frame", "param1", "param2", "param3", "param4", "param5", "param6", "param7"]
    value: float | None


class MoveItem(PageMessage):
    """An item of a mission is put somewhere else."""

    op: Literal["move_item"] = "move_item"
    seq: int
    place: LngLat


class InsertItem(PageMessage):
    """An item that becomes number `seq`, as high as the one before it."""

    op: Literal["insert_item"] = "insert_item"
    seq: int
    command: int
    place: LngLat | None = None


class TakeItem(PageMessage):
    """An item is taken out of a mission."""

    op: Literal["take_item"] = "take_item"
    seq: int


class PlainItems(PageMessage):
    """The survey or scan that an item is one of becomes plain items."""

    op: Literal["plain_items"] = "plain_items"
    seq: int


ItemChange: TypeAlias = PutItem | MoveItem | InsertItem | TakeItem | PlainItems
AreaChange: TypeAlias = DrawArea | OwnArea | MapArea | PutCorner | AddCorner
Change: TypeAlias = Annotated[Put | Take | Shift | Add | AreaChange | ItemChange, Field(discriminator="op")]


class Edit(PageMessage):
    """Change the document; `seen` is the revision that the page knew."""

    kind: Literal["edit"] = "edit"
    seen: int
    label: str
    changes: tuple[Change, ...]


class Rewrite(PageMessage):
    """The scenario's text is another one."""

    kind: Literal["rewrite"] = "rewrite"
    seen: int
    text: str


class Drag(PageMessage):
    """How would it be, were it so? The answer goes to this page alone; of several questions the last counts."""

    kind: Literal["drag"] = "drag"
    number: int
    changes: tuple[Change, ...]


class SaveAs(PageMessage):
    """Write the mission beside its file, over nothing, as the other format or under another name."""

    kind: Literal["save_as"] = "save_as"
    suffix: Literal[".plan", ".waypoints"]


class Within(PageMessage):
    """In the world of which scenario a mission is judged, and who flies it; None: of none, whom the file says."""

    kind: Literal["within"] = "within"
    scenario: str | None
    autopilot: str | None


class Open(PageMessage):
    """Open a file that the start page was told of."""

    kind: Literal["open"] = "open"
    path: str


class Begin(PageMessage):
    """A new scenario, home at a place as people write it, so high [m AMSL]."""

    kind: Literal["begin"] = "begin"
    place: str
    altitude: Annotated[float, Field(ge=-450, le=9000)]


class Find(PageMessage):
    """Where on the map is a place, as people write it?"""

    kind: Literal["find"] = "find"
    place: str


class Rest(PageMessage):
    """Plan what is left of the survey where these logs beside it say that some was flown; none: all of it again."""

    kind: Literal["rest"] = "rest"
    logs: tuple[str, ...]


class Do(PageMessage):
    """Something with no more to it. `take_theirs`: the file as another program has written it.

    `detach`: the planned flight, of a survey's the one of this number from 0 on, as a mission file of its own, to be
    changed item by item.
    """

    kind: Literal["do"] = "do"
    what: Literal["undo", "redo", "save", "save_over", "take_theirs", "plan", "cancel", "export", "abandon", "detach"]
    flight: Annotated[int, Field(ge=0)] = 0


class Upload(PageMessage):
    """The first step of a flight: put the mission on a vehicle, and read it back. No link: the built-in one.

    `set_params`: give it the parameters that the mission was made for. `flight`: which one of a survey's, from 0 on.
    `charged`: the user says that a charged battery is in, and that nobody is near the propellers, which on a link is
    asked for after another one of them was flown.
    """

    kind: Literal["upload"] = "upload"
    link: str | None = None
    system: int | None = None
    speedup: Annotated[float, Field(ge=0.1, le=1000)] = 1.0
    set_params: bool = False
    flight: Annotated[int, Field(ge=0)] = 0
    charged: bool = False


class Start(PageMessage):
    """The second step: arm and fly. It names what the page showed, and is refused if that is not what is there."""

    kind: Literal["start"] = "start"
    vehicle: str
    mission: str
    proof: str


class Listen(PageMessage):
    """Who is heard on the links that there may be, and on this one?"""

    kind: Literal["listen"] = "listen"
    link: str


class Order(PageMessage):
    """Have the vehicle in flight hold its place, go on with its mission, come home, or land where it is."""

    kind: Literal["order"] = "order"
    what: InFlight


Request: TypeAlias = Annotated[
    Edit | Rewrite | Drag | Do | Rest | SaveAs | Within | Open | Begin | Find | Upload | Start | Order | Listen,
    Field(discriminator="kind"),
]
REQUESTS: TypeAdapter[Any] = TypeAdapter(Request)
