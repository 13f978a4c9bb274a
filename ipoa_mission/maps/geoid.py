"""Rules of elevation models, and the geoid: one value serves a flight, as it tilts by centimeters over kilometers."""

from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field
from pyproj import Transformer
from pyproj.exceptions import ProjError

from ipoa_mission.errors import BadInput, NotCovered

# Best match to an autopilot's mean sea level first.
GRIDS = ("us_nga_egm96_15.tif", "egm96_15.gtx", "us_nga_egm08_25.tif", "egm08_25.gtx")


class ElevationRules(BaseModel):
    """Rules for the heights of a file; `geoid`: [m] or a PROJ grid."""

    model_config = ConfigDict(frozen=True, defer_build=True)

    heights: Literal["amsl", "ellipsoidal"] | None = None
    """Datum of its heights: mean sea level (SRTM), or the WGS 84 ellipsoid. Default: as the file states."""
    geoid: float | Path | None = None
    spacing: Annotated[float, Field(gt=0, strict=True)] | None = None
    """Distance between the nodes of the local grid [m]. Default: that of the model's posts."""
    nodata: float | None = None
    """Number that marks a missing height, if the file does not state it."""
    level_at_home: bool = False
    """Shift the model so that its ground at home is at home's altitude: only differences count then."""


def undulation(latitude_deg: float, longitude_deg: float, known: float | Path | None, place: Path) -> tuple[float, str]:
    """Return the height above WGS 84 [m], and its source; `known`: height or PROJ grid."""
    if isinstance(known, int | float):
        return float(known), "as given"
    for grid in GRIDS if known is None else (str(known),):
        try:
            shift = Transformer.from_pipeline(
                "+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad "
                f'+step +proj=vgridshift +grids="{grid}" +multiplier=1'
            )
            height = shift.transform(longitude_deg, latitude_deg, 0.0, errcheck=True)[2]
        except ProjError:
            continue
        return float(height), f"by {Path(grid).name}"
    if known is not None:
        words = f"expected a PROJ grid that covers {latitude_deg:.4f}, {longitude_deg:.4f}: {known}"
        raise NotCovered(words, place="terrain.geoid")
    raise BadInput(
        "expected PROJ's grid of the geoid on this machine, since heights are above the ellipsoid",
        hint=f"set terrain.geoid to the geoid's height there in meters, or get it by `pyproj sync --file {GRIDS[0]}`; "
        "or set terrain.level_at_home = true",
        place=place,
    )
