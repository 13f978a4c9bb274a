"""Check positions that no vehicle should fly to."""

import math
from collections.abc import Iterable, Iterator

from ipoa_mission.autopilot.commands import FLOWN_TO, Command, Frame, plain_frame
from ipoa_mission.errors import BadInput
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.geodesy import Geodetic, apart
from ipoa_mission.mission.items import FenceCircle, FencePolygon, Item, Mission, Numbered, numbered_items

MAX_DISTANCE = 100_000.0  # from home [m]
MIN_HEIGHT = -500.0  # above home [m]
MAX_HEIGHT = 10_000.0  # above home [m]
POSITION_OPTIONAL = {Command.NAV_TAKEOFF, Command.NAV_LAND, Command.NAV_PAYLOAD_PLACE}


def check_positions(mission: Mission) -> Iterator[Finding]:
    yield from _home(mission)
    elsewhere = home_elsewhere(mission)
    if elsewhere:
        yield Finding("home-elsewhere", Severity.WARNING, 0, elsewhere)
    placed = FLOWN_TO | mission.firmware.placed.keys()
    for at in numbered_items(mission):
        if at.item.command in placed and at.item.frame != Frame.MISSION:
            findings = list(_position(at, mission))
            yield from findings
            if not findings and not elsewhere:
                yield from _far(at, mission.home)
            yield from _height(at, mission)
    yield from _fence(mission)
    for n, place in enumerate(mission.rally):
        if wrong := _wrong_corner(mission.home, place.latitude_deg, place.longitude_deg):
            yield Finding("rally-place", Severity.ERROR, None, f"rally[{n}]: {wrong}")
        elif not MIN_HEIGHT <= place.altitude <= MAX_HEIGHT:
            message = f"rally[{n}]: expected {MIN_HEIGHT:g} to {MAX_HEIGHT:g} m above home, not {place.altitude:g} m"
            yield Finding("rally-height", Severity.ERROR, None, message)


def _fence(mission: Mission) -> Iterator[Finding]:
    for n, part in enumerate(mission.fence):
        corners = part.vertices if isinstance(part, FencePolygon) else (part.center,)
        wrong = next(filter(None, (_wrong_corner(mission.home, *corner) for corner in corners)), None)
        if isinstance(part, FenceCircle) and not 0 < part.radius <= MAX_DISTANCE:
            wrong = f"expected a radius above zero and up to {MAX_DISTANCE / 1000:g} km, not {part.radius:g} m"
        if wrong:
            yield Finding("fence-place", Severity.ERROR, None, f"fence[{n}]: {wrong}")


def _wrong_corner(home: Geodetic, latitude_deg: float, longitude_deg: float) -> str | None:
    if wrong := out_of_range(latitude_deg, longitude_deg):
        return wrong
    if out_of_range(home.latitude_deg, home.longitude_deg):
        return None
    meters = apart(home, Geodetic(latitude_deg, longitude_deg))
    return None if meters <= MAX_DISTANCE else f"expected a position within 100 km of home, not {meters / 1000:.0f} km"


def home_elsewhere(mission: Mission) -> str | None:
    """Report a far home in an ArduPilot file: ArduCopter replaces it where it is armed."""
    placed = [item for item in mission.items if item.has_position and item.command != Command.NAV_TAKEOFF]
    places = [(item.latitude_deg, item.longitude_deg) for item in placed]
    home = (mission.home.latitude_deg, mission.home.longitude_deg)
    if not places or not mission.autopilot.guidance.home_is_where_armed:
        return None
    if any(out_of_range(*place) for place in (home, *places)):
        return None
    nearest = min(apart(mission.home, Geodetic(*place)) for place in places)
    if nearest <= MAX_DISTANCE or any(apart(Geodetic(*places[0]), Geodetic(*place)) > MAX_DISTANCE for place in places):
        return None
    return f"home: it lies {nearest / 1000:.0f} km from all places of the mission: the vehicle must be armed elsewhere"


def refuse_unsound(mission: Mission) -> None:
    """Raise BadInput for a mission that cannot be drawn."""
    for finding in unsound(check_positions(mission)):
        raise BadInput(finding.message, code=finding.code)
    for n, part in enumerate(mission.fence):
        if isinstance(part, FencePolygon) and len(part.vertices) < 3:
            words = f"expected a polygon of three vertices or more, not {len(part.vertices)}"
            raise BadInput(words, code="fence-shape", place=f"fence[{n}]")


def refusals(mission: Mission) -> tuple[str, ...]:
    return tuple(finding.message for finding in unsound(check_positions(mission)))


def unsound(positions: Iterable[Finding]) -> list[Finding]:
    errors = [each for each in positions if each.severity is Severity.ERROR or each.code == "home-elsewhere"]
    return sorted(errors, key=lambda finding: finding.code == "home-elsewhere")


def _home(mission: Mission) -> Iterator[Finding]:
    home = mission.home
    if wrong := out_of_range(home.latitude_deg, home.longitude_deg):
        yield Finding("home-place", Severity.ERROR, 0, f"home: {wrong}")
    elif (home.latitude_deg, home.longitude_deg) == (0.0, 0.0):
        needed = any(item.has_position for item in mission.items)
        message = "home: expected a position, not latitude 0, longitude 0"
        yield Finding("home-unknown", Severity.ERROR if needed else Severity.WARNING, 0, message)
    if not -450.0 <= home.altitude <= 9_000.0:
        message = f"home: expected an altitude AMSL from -450 to 9000 m, not {home.altitude:g}"
        yield Finding("home-altitude", Severity.ERROR, 0, message)


def out_of_range(latitude_deg: float, longitude_deg: float) -> str | None:
    if not abs(latitude_deg) <= 90:
        return f"expected a latitude from -90 to 90 degrees, not {latitude_deg:g}"
    if not abs(longitude_deg) <= 180:
        return f"expected a longitude from -180 to 180 degrees, not {longitude_deg:g}"
    return None


def _position(at: Numbered, mission: Mission) -> Iterator[Finding]:
    item = at.item
    model = mission.autopilot.model
    if wrong := out_of_range(item.latitude_deg, item.longitude_deg):
        yield at.error("position-out-of-range", wrong)
    elif item.command in FLOWN_TO and (item.latitude_deg, item.longitude_deg) == (0.0, 0.0):
        if item.is_here(mission.autopilot):
            if item.command not in POSITION_OPTIONAL:
                yield at.warning("position-here", f"latitude 0, longitude 0: {model} runs it at its current place")
        elif item.command not in POSITION_OPTIONAL:
            yield at.error("position-missing", "expected a position, not latitude 0, longitude 0")
        elif not mission.autopilot.guidance.zero_is_here:
            yield at.error("position-missing", f"expected a position: {model} would fly to latitude 0, longitude 0")


def _far(at: Numbered, home: Geodetic) -> Iterator[Finding]:
    item = at.item
    if not item.has_position or out_of_range(home.latitude_deg, home.longitude_deg):
        return
    km = apart(home, Geodetic(item.latitude_deg, item.longitude_deg)) / 1000
    if km > MAX_DISTANCE / 1000:
        yield at.error("too-far", f"expected a position within {MAX_DISTANCE / 1000:g} km of home, not {km:.0f} km")
    elif km > 10.0:
        yield at.warning("far", f"lies {km:.1f} km from home")


def _height(at: Numbered, mission: Mission) -> Iterator[Finding]:
    item = at.item
    if item.command not in FLOWN_TO:
        return
    if not math.isfinite(item.altitude):
        yield at.error("altitude-missing", f"expected an altitude in meters, not {item.altitude}")
        return
    if item.is_as_high_as_now(mission.autopilot):
        if item.command != Command.NAV_PAYLOAD_PLACE:
            yield at.warning("altitude-kept", f"altitude 0: {mission.autopilot.model} keeps its height")
        return
    if plain_frame(item.frame) == Frame.GLOBAL_TERRAIN_ALT:
        if not (item.altitude > 0 or item.command == Command.NAV_LAND) or abs(item.altitude) > MAX_HEIGHT:
            yield at.error("height-over-terrain", f"expected a height above the terrain, not {item.altitude:g} m")
        return
    height = mission.altitude_above_home(item)
    if math.isnan(height):
        return  # `check_firmware` reports it
    if not MIN_HEIGHT <= height <= MAX_HEIGHT:
        message = f"expected a height from {MIN_HEIGHT:g} to {MAX_HEIGHT:g} m above home, not {height:g} m"
        yield at.error("height-absurd", message + _doubt(item, mission))
    elif height <= 0 and item.command not in POSITION_OPTIONAL:
        words = f"lies {-height:g} m below home" if height else "is at the height of home: its altitude may be missing"
        yield at.warning("below-home", words + _doubt(item, mission))


def _doubt(item: Item, mission: Mission) -> str:
    mistaken = plain_frame(item.frame) == Frame.GLOBAL and 0 < item.altitude < mission.home.altitude
    return ": perhaps it is meant above home (frame 3), not AMSL (frame 0)" if mistaken else ""
