"""Hypothesis strategies for missions."""

import math

from hypothesis import strategies as st

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.commands import Command
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.mission.items import FenceCircle, FencePolygon, Item, Mission
from ipoa_mission.mission.waypoints_file import OTHER_LISTS

LATITUDE = st.floats(-90, 90)
LONGITUDE = st.floats(-180, 180)
METERS = st.floats(-500, 9000)
PARAM = st.floats(-1e6, 1e6) | st.integers(-360, 360).map(float)
PARAM_OR_NAN = PARAM | st.just(math.nan)
VERTEX = st.tuples(LATITUDE, LONGITUDE)
POLYGONS = st.builds(FencePolygon, st.lists(VERTEX, min_size=3, max_size=5).map(tuple), st.booleans())
CIRCLES = st.builds(FenceCircle, VERTEX, st.floats(0.1, 1e5), st.booleans())
PLACES = st.builds(Geodetic, LATITUDE, LONGITUDE, METERS)


def items(autopilot: Autopilot, frames: tuple[int, ...], nan: bool) -> st.SearchStrategy[Item]:
    """Items that the firmware knows, with a position in one of `frames` or without."""
    firmware = autopilot.firmware()
    param = PARAM_OR_NAN if nan else PARAM
    params = st.tuples(param, param, param, param)
    placed = st.sampled_from(sorted(set(firmware.placed) - set(firmware.plain) - OTHER_LISTS))
    plain = st.sampled_from(sorted(set(firmware.plain) - set(firmware.placed) - {Command.DO_JUMP}))
    return st.builds(
        Item, placed, st.sampled_from(frames), params, LATITUDE, LONGITUDE, METERS, st.booleans()
    ) | st.builds(Item, plain, st.just(2), params, autocontinue=st.booleans())


@st.composite
def missions(draw: st.DrawFn, frames: tuple[int, ...] = (0, 3, 10), nan: bool = True, fences: bool = True) -> Mission:
    """Jumps lead somewhere; polygons of a fence precede its circles, as in files."""
    autopilot = draw(st.sampled_from(list(registered())))
    flown = draw(st.lists(items(autopilot, frames, nan), max_size=6))
    jumps = draw(st.lists(st.integers(1, len(flown)), max_size=2)) if flown else []
    return Mission(
        draw(PLACES),
        (*flown, *(Item(Command.DO_JUMP, 2, (float(target), 2.0, 0.0, 0.0)) for target in jumps)),
        autopilot,
        draw(st.none() | st.floats(0.1, 50)),
        tuple(draw(st.lists(POLYGONS, max_size=2)) + draw(st.lists(CIRCLES, max_size=2))) if fences else (),
        tuple(draw(st.lists(PLACES, max_size=2))) if fences else (),
    )


def any_missions() -> st.SearchStrategy[Mission]:
    """Missions of numbers in and beyond their ranges: all that the API can build."""
    degrees = LATITUDE | st.floats(-500, 500)
    number = st.floats() | PARAM
    item = st.builds(
        Item,
        st.integers(-1, 70_000) | st.sampled_from(list(Command)),
        st.integers(-1, 300) | st.sampled_from([0, 2, 3, 10]),
        st.tuples(number, number, number, number),
        degrees,
        degrees,
        number,
        st.booleans(),
    )
    corner = st.tuples(degrees, degrees)
    polygon = st.builds(FencePolygon, st.lists(corner, max_size=4).map(tuple), st.booleans())
    circle = st.builds(FenceCircle, corner, number, st.booleans())
    place = st.builds(Geodetic, degrees, degrees, number)
    return st.builds(
        Mission,
        place | PLACES,
        st.lists(item, max_size=3).map(tuple),
        st.sampled_from(list(registered())),
        st.none() | number,
        st.lists(polygon | circle, max_size=2).map(tuple),
        st.lists(place, max_size=2).map(tuple),
        vehicle_type=st.just(2) | st.integers(-1, 300),
    )


def same(one: Mission, other: Mission) -> bool:
    """Take NaN for NaN, -0 for 0, and a command for its number."""
    return _bare(one) == _bare(other)


def _bare(mission: Mission) -> tuple[object, ...]:
    items = [
        (
            int(i.command),
            int(i.frame),
            [str(float(p) + 0.0) for p in i.params],
            i.latitude_deg,
            i.longitude_deg,
            i.altitude,
        )
        for i in mission.items
    ]
    on = [i.autocontinue for i in mission.items]
    return mission.home, items, on, mission.autopilot, mission.cruise_speed, mission.fence, mission.rally
