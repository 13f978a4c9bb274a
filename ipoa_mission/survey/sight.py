"""How high a survey is flown, and what is seen from there: spacing of the lines, distance between photos, footprint."""

import math
from dataclasses import dataclass

import numpy as np
import shapely

from ipoa_mission.errors import BadInput, Remedy
from ipoa_mission.scenario import Scenario
from ipoa_mission.scenario.survey_section import BAND, SurveySection
from ipoa_mission.survey.area import Area
from ipoa_mission.survey.tour import Tour

LEVEL = 0.05  # ground whose heights differ by less is flat [m]
LOOKS = 40  # lines each way on which the ground is looked at
LEAST_TRIGGER = 0.1  # [m]
CLOSEST = 0.5  # lines, and photos, nearer to each other are a mistake [m]
SPACING = ("survey", "line_spacing")


@dataclass(frozen=True)
class Sight:
    """What is asked of the flight, in metres.

    Attributes:
        least: height above the highest ground that is seen at a moment, at least.
        band: how much higher the flight may be; 0 over flat ground.
        spacing: between lines.
        trigger: between photos along a line; None: no camera.
        across: how wide what is seen is at the least height; without a camera as wide as the spacing.
        along: how long; 0 without a camera.
        lag: how much farther apart photos are in the mean than they are triggered, as the way is looked at from time to
            time; at most twice as much.
    """

    least: float
    band: float
    spacing: float
    trigger: float | None
    across: float
    along: float
    lag: float = 0.0

    @property
    def middle(self) -> float:
        """The height above the highest ground that is aimed at."""
        return self.least + self.band / 2

    @property
    def overlaps(self) -> tuple[float, float]:
        """What share of a photo the next one, and those of the next line, are to show too; 0 without a camera."""
        front = 0.0 if self.trigger is None else 1.0 - self.trigger / self.along
        return front, 1.0 - self.spacing / self.across

    def triggering(self, length: float) -> tuple[float, int]:
        """How far apart photos are triggered along a line of this length [m], and how many that makes.

        They are no farther apart than they may be, and the last one is half a step before the end: wherever a flight
        begins and ends the line by a few meters it takes as many, and all of the line is in a photo.
        """
        if self.trigger is None:
            return 0.0, 0
        most = max(self.trigger - self.lag, LEAST_TRIGGER)
        steps = max(math.ceil(length / most - 0.5 - 1e-9), 0)
        between = length / (steps + 0.5) if steps else most
        return max(between - self.lag, LEAST_TRIGGER), 1 + steps

    def photos(self, length: float) -> int:
        """How many are taken along a line of this length [m]."""
        return self.triggering(length)[1]

    def photos_of(self, tour: Tour) -> int:
        """How many are taken on all lines of a tour."""
        return sum(self.photos(swath.length) for swath in tour.swaths)


def sight_of(section: SurveySection, area: Area, scenario: Scenario) -> Sight:
    """What a scenario asks of its survey.

    Raises:
        BadInput: lines or photos are so near to each other that it must be a mistake.
    """
    share = 0.0 if _is_level(area, scenario) else BAND
    least = section.height if section.height_above_ground is not None else section.height / (1.0 + share)
    camera, spacing, trigger = section.taken_by, section.spacing(least), section.trigger(least)
    across, along = (spacing, 0.0) if camera is None else camera.footprint(least)
    for key, distance in (
        ("line_spacing" if section.line_spacing else "side_overlap", spacing),
        ("front_overlap", trigger),
    ):
        if distance is not None and distance < CLOSEST:
            raise BadInput(
                f"expected lines and photos {CLOSEST:g} m apart or more, not {distance:.2f} m",
                code="lines-too-near",
                place=f"survey.{key}",
                remedies=() if key == "line_spacing" else (Remedy(("survey", key)),),
            )
    if spacing > across + 1e-9:
        raise BadInput(
            f"expected at most what a photo shows, {across:.1f} m, not {spacing:g} m",
            code="lines-too-far-apart",
            place="survey.line_spacing",
            remedies=(Remedy(SPACING, math.floor(across * 10) / 10), Remedy(SPACING)),
        )
    vehicle = scenario.vehicle
    lag = vehicle.autopilot.firmware(vehicle.version).photo_looks_s / 2 * vehicle.cruise_speed
    return Sight(least, share * least, spacing, trigger, across, along, lag)


def _is_level(area: Area, scenario: Scenario) -> bool:
    west, south, east, north = shapely.bounds(area.shape).tolist()
    grid = np.meshgrid(np.linspace(west, east, LOOKS), np.linspace(south, north, LOOKS))
    ground = scenario.airspace.ground(np.stack(grid, axis=-1).reshape(-1, 2))
    return bool(np.ptp(ground) < LEVEL)
