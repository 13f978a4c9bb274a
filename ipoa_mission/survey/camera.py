from collections.abc import Mapping
from difflib import get_close_matches
from typing import Annotated, Any, TypeAlias

from pydantic import BeforeValidator, GetJsonSchemaHandler

from ipoa_mission.errors import UnknownName
from ipoa_mission.scenario.section import Count, Positive, Section


class CameraSection(Section):
    """A camera by its numbers."""

    sensor_mm: tuple[Positive, Positive]
    """Width and height of the sensor [mm]. The width is across the track."""
    focal_length_mm: Positive
    """Focal length of the lens itself [mm], not the 35 mm equivalent."""
    pixels: tuple[Count, Count]
    """Width and height of a photo."""
    name: str = "camera"
    """Name of the camera."""

    def footprint(self, height: float) -> tuple[float, float]:
        """Return the footprint across and along [m].

        >>> CAMERAS["Sony A6000 16mm"].footprint(80.0)
        (117.5, 78.0)
        """
        across, along = self.sensor_mm
        return across * height / self.focal_length_mm, along * height / self.focal_length_mm

    def height_for(self, gsd_cm: float) -> float:
        """Return the height at which a pixel covers `gsd_cm` [m]."""
        pitch = max(side / count for side, count in zip(self.sensor_mm, self.pixels, strict=True))
        return gsd_cm / 100 * self.focal_length_mm / pitch


# QGroundControl's CameraMetaData, DJI's and Sony's data sheets
CAMERAS: Mapping[str, CameraSection] = {
    name: CameraSection(sensor_mm=sensor, focal_length_mm=focal_length, pixels=pixels, name=name)
    for name, (sensor, focal_length, pixels) in {
        "Sony ILCE-QX1": ((23.2, 15.4), 16.0, (5456, 3632)),
        "Sony A6000 16mm": ((23.5, 15.6), 16.0, (6000, 4000)),
        "Canon S100 PowerShot": ((7.6, 5.7), 5.2, (4000, 3000)),
        "Canon SX260 HS PowerShot": ((6.17, 4.55), 4.5, (4000, 3000)),
        "DJI Zenmuse P1 35mm": ((35.9, 24.0), 35.0, (8192, 5460)),
        "DJI Mavic 3E": ((17.3, 13.0), 12.29, (5280, 3956)),
    }.items()
}


class _OrName:
    def __get_pydantic_json_schema__(self, core_schema: Any, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        return {"anyOf": [{"type": "string"}, handler(core_schema)]}


def _by_name(value: Any) -> Any:
    if not isinstance(value, str):
        return value
    by_letters = {known.casefold(): camera for known, camera in CAMERAS.items()}
    if value.casefold() in by_letters:
        return by_letters[value.casefold()]
    near = get_close_matches(value.casefold(), by_letters, n=1)
    hint = f"; did you mean {by_letters[near[0]].name!r}?" if near else f", one of {', '.join(CAMERAS)}"
    words = f"expected the name of a known camera{hint} (give one by its numbers: sensor_mm, focal_length_mm, pixels)"
    raise ValueError(words) from UnknownName(words)


GivenCamera: TypeAlias = Annotated[CameraSection, BeforeValidator(_by_name), _OrName()]
