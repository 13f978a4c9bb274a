"""What the page asks of the server, and the changes of a scenario that it asks for."""

from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Field, TypeAdapter

from ipoa_mission.studio.vocabulary import Json, LngLat, PageMessage, Path


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


Change: TypeAlias = Annotated[Put | Take | Shift | Add, Field(discriminator="op")]


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


class Do(PageMessage):
    """Something with no more to it. `take_theirs`: the file as another program has written it."""

    kind: Literal["do"] = "do"
    what: Literal["undo", "redo", "save", "save_over", "take_theirs", "plan", "cancel", "export", "abandon"]


class Upload(PageMessage):
    """The first step of a flight: put the proved mission on a vehicle, and read it back. No link: the built-in one."""

    kind: Literal["upload"] = "upload"
    link: str | None = None
    system: int | None = None
    speedup: Annotated[float, Field(ge=0.1, le=1000)] = 1.0


class Start(PageMessage):
    """The second step: arm and fly. It names what the page showed, and is refused if that is not what is there."""

    kind: Literal["start"] = "start"
    vehicle: str
    mission: str
    proof: str


class EndFlight(PageMessage):
    """Have the vehicle in flight come home, or land where it is."""

    kind: Literal["end_flight"] = "end_flight"
    ending: Literal["rtl", "land"]


Request: TypeAlias = Annotated[Edit | Rewrite | Drag | Do | Upload | Start | EndFlight, Field(discriminator="kind")]
REQUESTS: TypeAdapter[Any] = TypeAdapter(Request)
