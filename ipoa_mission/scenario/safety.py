"""How sure the clearance of a scenario's flights must be."""

from typing import Annotated, Literal

from pydantic import Field, field_validator

from ipoa_mission.errors import BadInput
from ipoa_mission.rules import expect_ignorable
from ipoa_mission.scenario.section import Section


class SafetySection(Section):
    """How sure the clearance is."""

    confidence: Annotated[float, Field(ge=0.5, le=0.999)] | Literal["nominal"] = 0.99
    """The share of flights that keep the required clearance, by how far this autopilot flies beside its predicted path;
    `nominal`: what the predicted path keeps, as the paper has it."""
    returns: Literal["planned", "warn"] = "warn"
    """`planned`: RTL, SmartRTL and holding are clear from every second of the flight, by another path, a return
    altitude or rally points, and so is LAND where `vehicle.parameters` make a failsafe land that could return; a flight
    of which they cannot be is refused. `warn`: only a warning tells of RTL that is not clear. `ipoa-mission new` writes
    `planned`."""
    ignore: tuple[str, ...] = ()
    """Codes of findings that are not to be told; those from which a crash may follow are told all the same."""

    @field_validator("ignore")
    @classmethod
    def _may_be_ignored(cls, codes: tuple[str, ...]) -> tuple[str, ...]:
        try:
            expect_ignorable(codes)
        except BadInput as error:
            raise ValueError(str(error)) from error
        return codes

    @property
    def ignored(self) -> frozenset[str]:
        """The same, to look codes up."""
        return frozenset(self.ignore)

    @property
    def chance(self) -> float | None:
        """With what chance a flight may come nearer than it must; None if only the predicted path counts."""
        return None if self.confidence == "nominal" else 1.0 - self.confidence
