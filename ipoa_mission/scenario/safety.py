from typing import Annotated, Literal

from pydantic import Field, field_validator

from ipoa_mission.errors import BadInput
from ipoa_mission.rules import expect_ignorable
from ipoa_mission.scenario.section import Section


class SafetySection(Section):
    """Confidence in the clearance."""

    confidence: Annotated[float, Field(ge=0.5, le=0.999)] | Literal["nominal"] = 0.99
    """Share of flights that keep the required clearance, by this autopilot's lateral deviation from its predicted path.
    `nominal`: clearance of the predicted path, as in the paper."""
    returns: Literal["planned", "warn"] = "warn"
    """`planned`: RTL, SmartRTL and holding are clear from every second of the flight. Another path, a return altitude
    or rally points achieve it; otherwise the flight is refused. LAND must be clear too where `vehicle.parameters` make
    a failsafe land although it could return. `warn`: an RTL without clearance is only a warning. `ipoa-mission new`
    writes `planned`."""
    ignore: tuple[str, ...] = ()
    """Codes of findings to ignore. Findings that may mean a crash are reported anyway."""

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
        return frozenset(self.ignore)

    @property
    def chance(self) -> float | None:
        """Return the accepted probability of less clearance."""
        return None if self.confidence == "nominal" else 1.0 - self.confidence
