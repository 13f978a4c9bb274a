"""What all messages are made of. Positions on the map are [longitude, latitude] in degrees, as in GeoJSON."""

from typing import Annotated, Any, TypeAlias

from pydantic import BaseModel, ConfigDict, WithJsonSchema

LngLat: TypeAlias = tuple[float, float]
Path: TypeAlias = tuple[str | int, ...]
Json: TypeAlias = Annotated[Any, WithJsonSchema({})]


class PageMessage(BaseModel):
    """Says no more than it is meant to."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)
