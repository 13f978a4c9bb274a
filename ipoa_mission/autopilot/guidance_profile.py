"""Properties of mission execution."""

from collections.abc import Set
from dataclasses import dataclass
from typing import NamedTuple


class WaypointDefaults(NamedTuple):
    """Hold [s], below which a waypoint may be passed, and radius [m]; 0: its parameter."""

    hold: float = 0.0
    radius: float = 0.0


@dataclass(frozen=True)
class GuidanceProfile:
    """Properties of one autopilot's mission mode."""

    flown_on_into: Set[int]
    """Entered without a stop after a waypoint, unlike other navigation commands."""
    flies_vtol_items: bool = False
    """As take-off and landing of a multicopter."""
    zero_is_here: bool = False
    """Latitude and longitude 0: the previous place; altitude 0: its height."""
    stops_to_hold: bool = False
    """At an item with a hold of 1 s or more; shorter holds are ignored."""
    stops_at_terrain: bool = False
    """Between an altitude over terrain and another frame."""
    flies_splines: bool = False
    """NAV_SPLINE_WAYPOINT."""
    climbs_where_it_stands: bool = False
    """A take-off is vertical."""
    needs_takeoff: bool = False
    """On the ground."""
    least_takeoff: tuple[str, float] | None = None
    """A parameter [m], and a take-off's margin above it [m]."""
    own_takeoff: float = 0.0
    """Least height of a take-off [m]."""
    waits_armed: str = ""
    """The parameter of the time until it disarms on the ground [s]; empty: never."""
    waits_until_clock: bool = False
    """NAV_DELAY without seconds."""
    terrain_by: str = ""
    """Arming with items over terrain needs terrain data or this parameter's range finder."""
    takes_radius: bool = False
    """The acceptance radius determines where it turns."""
    first_item: int = 1
    """In the stored list's jumps."""
    past_the_end: int = 0
    """Current item after a shorter list: 0, or -1 for the last."""
    lands_below_item: bool = False
    """LAND's slow stretch counts from an item below home."""
    climb_ends_at_once: bool = False
    """Within 0.5 m, when a mission is aborted."""
    climbs_coming_back: bool = False
    """RTL climbs on its way back to the point of the order."""
    home_is_where_armed: bool = False
    """The file's home is ignored."""
    brakes_after: float = 0.0
    """Longest delay on an abort [s]. As flown: docs/safety.md."""
