"""How high a survey is flown, and what is seen from there: spacing of the lines, distance between photos, footprint."""

from dataclasses import dataclass

import numpy as np
import shapely

from ipoa_mission.errors import BadInput
from ipoa_mission.scenario import Scenario
from ipoa_mission.scenario.survey import BAND, SurveySection
from ipoa_mission.survey.area import Area

LEVEL = 0.05  # ground whose heights differ by less is flat [m]
LOOKS = 40  # lines each way on which the ground is looked at
CLOSEST = 0.5  # lines, and photos, nearer to each other are a mistake [m]


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
    """

    least: float
    band: float
    spacing: float
    trigger: float | None
    across: float
    along: float

    @property
    def middle(self) -> float:
        """The height above the highest ground that is aimed at."""
        return self.least + self.band / 2

    def photos(self, length: float) -> int:
        """How many are taken along a line of this length [m]: one where it begins, then one each so far."""
        return 0 if self.trigger is None else 1 + int(np.floor(length / self.trigger + 1e-6))


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
            raise BadInput(f"survey.{key}: expected lines and photos {CLOSEST:g} m apart or more, not {distance:.2f} m")
    if spacing > across + 1e-9:
        raise BadInput(f"survey.line_spacing: expected at most what a photo shows, {across:.1f} m, not {spacing:g} m")
    return Sight(least, share * least, spacing, trigger, across, along)


def _is_level(area: Area, scenario: Scenario) -> bool:
    west, south, east, north = shapely.bounds(area.shape).tolist()
    grid = np.meshgrid(np.linspace(west, east, LOOKS), np.linspace(south, north, LOOKS))
    ground = scenario.airspace.ground(np.stack(grid, axis=-1).reshape(-1, 2))
    return bool(np.ptp(ground) < LEVEL)
