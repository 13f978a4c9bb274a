"""How an autopilot takes the items of a mission: what is flown on into, what stands for "here", where it stops."""

from collections.abc import Set
from dataclasses import dataclass
from typing import NamedTuple


class WaypointDefaults(NamedTuple):
    """A hold [s], without which the autopilot may pass a waypoint and not return; a radius [m], 0: its parameter."""

    hold: float = 0.0
    radius: float = 0.0


@dataclass(frozen=True)
class GuidanceProfile:
    """The habits of one autopilot's mission mode."""

    flown_on_into: Set[int]
    """Commands into which it flies on after a waypoint; before everything else that moves it, it comes to a stop."""
    flies_vtol_items: bool = False
    """NAV_VTOL_TAKEOFF and NAV_VTOL_LAND are take-off and landing of a multicopter, too."""
    zero_is_here: bool = False
    """Latitude and longitude 0 stand for the place, and altitude 0 for the height, of the item before."""
    stops_to_hold: bool = False
    """It comes to a stop where an item holds it for a second or more; a shorter hold is none."""
    stops_at_terrain: bool = False
    """It comes to a stop between an altitude over terrain and one that is not."""
    flies_splines: bool = False
    """NAV_SPLINE_WAYPOINT is a curve, and no waypoint."""
    climbs_where_it_stands: bool = False
    """A take-off is straight up, whatever position it names."""
    needs_takeoff: bool = False
    """A mission without a take-off is none for a vehicle that stands."""
    least_takeoff: tuple[str, float] | None = None
    """A parameter [m], and how much more than it a take-off must climb to be flown [m]."""
    own_takeoff: float = 0.0
    """To so high it climbs in any case [m]."""
    waits_armed: str = ""
    """The parameter that says how long it stands armed before it disarms by itself [s]; none: for ever."""
    waits_until_clock: bool = False
    """NAV_DELAY without seconds waits until a time of day."""
    terrain_by: str = ""
    """It is armed for items over terrain only with terrain data, or with the range finder of this parameter."""
    takes_radius: bool = False
    """The acceptance radius of a waypoint decides how early it turns."""
    first_item: int = 1
    """What a jump of the list as it is stored calls the first item."""
    past_the_end: int = 0
    """Where it stands in a shorter list that came while it was farther on: 0, or -1 for its last item."""
    lands_below_item: bool = False
    """LAND counts its slow stretch from the altitude of its item, where that is below home."""
    climb_ends_at_once: bool = False
    """A climb ends within half a meter when a mission is broken off."""
    climbs_coming_back: bool = False
    """Ordered home, it flies back to where the order reached it while it climbs."""
    home_is_where_armed: bool = False
    """The home of a file counts for nothing: where it is armed is home."""
    brakes_after: float = 0.0
    """For so long it flies on along its mission before it begins to brake, at most [s]. As flown: docs/safety.md."""
