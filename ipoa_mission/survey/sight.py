"""Derive line spacing, photo interval and flight heights that keep the requested overlap on slopes too."""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely

from ipoa_mission import Scenario
from ipoa_mission.errors import BadInput, Remedy
from ipoa_mission.geometry import Plane, Points, Vector
from ipoa_mission.ground import Ground
from ipoa_mission.survey.survey_area import Area
from ipoa_mission.survey.survey_section import BAND, SurveySection
from ipoa_mission.survey.tour import Tour

MIN_TRIGGER = 0.1  # [m]
USUAL_OVERLAP = 0.7


@dataclass(frozen=True)
class Sight:
    """The requested flight and view [m]."""

    least: float  # height above the highest ground in view
    band: float  # range of heights above `least`; 0 over flat ground
    spacing: float  # of lines
    trigger: float | None  # between photos; None without a camera
    across: float  # width of the view at the least height; without a camera the spacing
    along: float  # length of the view; 0 without a camera
    lag: float = 0.0  # mean delay of photos by the vehicle's polling; at most twice as much

    @property
    def middle(self) -> float:
        return self.least + self.band / 2

    @property
    def piece_overlap(self) -> float:
        return max(self.trigger or 0.0, self.along / 2, 1.0)

    @property
    def overlaps(self) -> tuple[float, float]:
        """Return the requested overlaps, front and side; 0 without a camera."""
        front = 0.0 if self.trigger is None else 1.0 - self.trigger / self.along
        return front, 1.0 - self.spacing / self.across

    def triggering(self, length: float) -> tuple[float, int]:
        """Return the trigger distance [m], and the number of photos; the last is half a step before the end."""
        if self.trigger is None:
            return 0.0, 0
        most = max(self.trigger - self.lag, MIN_TRIGGER)
        steps = max(math.ceil(length / most - 0.5 - 1e-9), 0)
        between = length / (steps + 0.5) if steps else most
        return max(between - self.lag, MIN_TRIGGER), 1 + steps

    def photos_of(self, tour: Tour) -> int:
        return sum(self.triggering(swath.length)[1] for swath in tour.swaths)


def sight_of(section: SurveySection, area: Area, scenario: Scenario) -> Sight:
    share = 0.0 if _is_level(area, scenario) else BAND
    least = section.height if section.height_above_ground is not None else section.height / (1.0 + share)
    if section.camera is None:
        across = section.line_spacing or 0.0
        along = 0.0
        trigger = None
    else:
        across, along = section.camera.footprint(least)
        trigger = along * (1.0 - (USUAL_OVERLAP if section.front_overlap is None else section.front_overlap))
    side_overlap = USUAL_OVERLAP if section.side_overlap is None else section.side_overlap
    spacing = section.line_spacing or across * (1.0 - side_overlap)
    spacing_key = "line_spacing" if section.line_spacing else "side_overlap"
    min_distance = 0.5  # [m]
    for key, distance in ((spacing_key, spacing), ("front_overlap", trigger)):
        if distance is not None and distance < min_distance:
            raise BadInput(
                f"expected lines and photos {min_distance:g} m apart or more, not {distance:.2f} m",
                code="lines-too-near",
                place=f"survey.{key}",
                remedies=() if key == "line_spacing" else (Remedy(("survey", key)),),
            )
    if spacing > across + 1e-9:
        key_path = ("survey", "line_spacing")
        raise BadInput(
            f"expected at most what a photo shows, {across:.1f} m, not {spacing:g} m",
            code="lines-too-far-apart",
            place="survey.line_spacing",
            remedies=(Remedy(key_path, math.floor(across * 10) / 10), Remedy(key_path)),
        )
    vehicle = scenario.vehicle
    lag = vehicle.autopilot.firmware(vehicle.version).photo_looks_s / 2 * vehicle.cruise_speed
    return Sight(least, share * least, spacing, trigger, across, along, lag)


def _is_level(area: Area, scenario: Scenario) -> bool:
    west, south, east, north = shapely.bounds(area.shape).tolist()
    grid = np.meshgrid(np.linspace(west, east, num=40), np.linspace(south, north, num=40))
    return bool(np.ptp(scenario.airspace.ground(np.stack(grid, axis=-1).reshape(-1, 2))) < 0.05)  # [m]


def lift_path(path: Plane, sight: Sight, ground: Ground) -> tuple[Points, list[int]]:
    """Return a path with heights and added places, and the indices of its corners."""
    if sight.band == 0.0:
        return np.column_stack([path, ground(path) + sight.least]), [*range(len(path))]
    sampled = [_sample_leg(a, b, sight, ground) for a, b in pairwise(path)]
    floor = np.array([lower[0] for _, lower in sampled] + [sampled[-1][1][-1]])
    floor[1:] = np.maximum(floor[1:], [lower[-1] for _, lower in sampled])
    heights = floor + sight.band / 2
    points = [np.append(path[0], heights[0])]
    corners = [0]
    for n, (a, b) in enumerate(pairwise(path)):
        shares, lower = sampled[n]
        lower[[0, -1]] = floor[n : n + 2]
        vertices = _fewest_points(shares, lower, sight.band, (heights[n], heights[n + 1]))
        points += [np.append(a + share * (b - a), height) for share, height in vertices]
        corners.append(len(points) - 1)
    return np.array(points), corners


def _sample_leg(a: Vector, b: Vector, sight: Sight, ground: Ground) -> tuple[Vector, Vector]:
    """Return shares of a straight leg, and the minimum flight height at each."""
    ahead = b - a
    samples = 9  # across the path, and along the photo
    length = float(np.linalg.norm(ahead))
    ahead = ahead / max(length, 1e-9)
    step = min(5.0, max(sight.across / samples, 0.5))  # [m]
    shares = np.linspace(0.0, 1.0, math.ceil(length / step) + 1)
    right = np.array([ahead[1], -ahead[0]])
    sides = np.linspace(-sight.across / 2, sight.across / 2, samples)
    along = np.linspace(-sight.along / 2, sight.along / 2, 1 if sight.along == 0.0 else samples)
    seen = (sides[:, None, None] * right + along[None, :, None] * ahead).reshape(-1, 2)
    spots = (a + shares[:, None] * (b - a))[:, None, :] + seen
    return shares, ground(spots.reshape(-1, 2)).reshape(len(shares), -1).max(axis=1) + sight.least


def _fewest_points(shares: Vector, lower: Vector, band: float, ends: tuple[float, float]) -> list[tuple[float, float]]:
    """Return the fewest places between which straight flight stays in the band above `lower`."""
    places = list[tuple[float, float]]()
    tolerance = 0.01  # [m]
    ahead = [(0, len(shares) - 1, *ends)]
    while ahead:
        first, last, begin, end = ahead.pop()
        part = slice(first, last + 1)
        line = np.interp(shares[part], shares[[first, last]], [begin, end])
        short = np.maximum(lower[part] - line, line - lower[part] - band)
        worst = first + int(np.argmax(short[1:-1])) + 1 if last - first > 1 else first
        if last - first <= 1 or short[worst - first] <= tolerance:
            places.append((float(shares[last]), end))
            continue
        middle = float(lower[worst]) + band / 2
        ahead += [(worst, last, middle, end), (first, worst, begin, middle)]
    return places
