"""Whether the vehicle stands where the mission takes off: heights in a mission are mostly above the vehicle's home."""

import math

from ipoa_mission.commands import Frame, plain_frame
from ipoa_mission.errors import MissionError
from ipoa_mission.items import Mission
from ipoa_mission.world.frame import Geodetic, apart

FAR = 100.0  # [m] over the ground
HIGHER = 5.0  # [m]


class FarFromHome(MissionError):
    """The vehicle is somewhere else; heights above home would be above another ground."""


def compare_homes(mission: Mission, there: Geodetic, anyway: bool = False) -> tuple[str, ...]:
    """Hold the vehicle's home against the mission's; what comes back are remarks for the user.

    Raises:
        FarFromHome: it is over 100 m away, heights count from home, and `anyway` does not say to send it all the same.
    """
    here = mission.home
    aside, higher = apart(here, there), there.altitude - here.altitude
    if aside > FAR:
        words = (
            f"the vehicle's home is {_distance(aside)} from the mission's: "
            f"it is at {_place(there)}, and the mission takes off at {_place(here)}"
        )
        if counts_from_home(mission) and not anyway:
            raise FarFromHome(
                words,
                hint="heights count from the vehicle's home: plan from where it stands, or send it with --anyway "
                f"(the built-in autopilot goes there by `mock --home {_words(here)}`)",
            )
        return (words,)
    if math.isfinite(higher) and abs(higher) > HIGHER:
        return (
            f"the vehicle's home is {abs(higher):.1f} m {'higher' if higher > 0 else 'lower'} than the mission's "
            f"({there.altitude:.1f} m AMSL, not {here.altitude:.1f} m); heights count from the vehicle's",
        )
    return ()


def counts_from_home(mission: Mission) -> bool:
    """Whether some height in the mission is above home."""
    return any(item.has_position and plain_frame(item.frame) == Frame.GLOBAL_RELATIVE_ALT for item in mission.items)


def _distance(metres: float) -> str:
    return f"{metres:.0f} m" if metres < 10_000 else f"{metres / 1000:.0f} km"


def _place(place: Geodetic) -> str:
    return f"{place.latitude_deg:.5f}, {place.longitude_deg:.5f}"


def _words(place: Geodetic) -> str:
    return f"{place.latitude_deg:.6f} {place.longitude_deg:.6f} {place.altitude:.1f}"
