"""Properties of an autopilot's mission execution."""

from collections.abc import Set
from dataclasses import dataclass
from typing import NamedTuple


class WaypointDefaults(NamedTuple):
    """The written hold [s], below which the autopilot may pass a waypoint, and radius [m]; 0: its parameter."""

    hold: float = 0.0
    radius: float = 0.0


@dataclass(frozen=True)
class GuidanceProfile:
    """Properties of one autopilot's mission mode."""

    flown_on_into: Set[int]
    """Commands that it enters without a stop after a waypoint; it stops before other navigation commands."""
    flies_vtol_items: bool = False
    """NAV_VTOL_TAKEOFF and NAV_VTOL_LAND act as take-off and landing of a multicopter."""
    zero_is_here: bool = False
    """Latitude and longitude 0 mean the previous item's place; altitude 0 means its height."""
    stops_to_hold: bool = False
    """It stops at an item with a hold of 1 s or more; shorter holds are ignored."""
    stops_at_terrain: bool = False
    """It stops between an altitude over terrain and one in another frame."""
    flies_splines: bool = False
    """NAV_SPLINE_WAYPOINT is flown as a curve."""
    climbs_where_it_stands: bool = False
    """A take-off is vertical, whatever position it names."""
    needs_takeoff: bool = False
    """On the ground a mission without a take-off is refused."""
    least_takeoff: tuple[str, float] | None = None
    """A parameter [m], and the margin above it that a take-off must climb [m]."""
    own_takeoff: float = 0.0
    """The least height of a take-off [m]."""
    waits_armed: str = ""
    """The parameter with the time until an armed vehicle on the ground disarms [s]; empty: never."""
    waits_until_clock: bool = False
    """NAV_DELAY without seconds waits for a time of day."""
    terrain_by: str = ""
    """Arming with items over terrain needs terrain data or the range finder of this parameter."""
    takes_radius: bool = False
    """A waypoint's acceptance radius determines where the vehicle turns."""
    first_item: int = 1
    """The number of the first item in the stored list's jumps."""
    past_the_end: int = 0
    """The current item after a shorter list replaces the mission: 0, or -1 for its last item."""
    lands_below_item: bool = False
    """LAND counts its slow stretch from the altitude of its item if that is below home."""
    climb_ends_at_once: bool = False
    """A climb ends within 0.5 m when a mission is aborted."""
    climbs_coming_back: bool = False
    """On RTL it climbs while it flies back to the point of the order."""
    home_is_where_armed: bool = False
    """Home is where it is armed; the file's home is ignored."""
    brakes_after: float = 0.0
    """The longest delay before it brakes on an abort [s]. As flown: docs/safety.md."""
