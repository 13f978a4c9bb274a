"""Firmware versions."""

import re
from dataclasses import dataclass

from ipoa_mission.errors import BadInput

_WRITTEN = re.compile(r"v?(\d{1,3})\.(\d{1,3})(?:\.(\d{1,3}))?(?:-?(dev|alpha|beta|rc)\d*)?", re.IGNORECASE)
#: FIRMWARE_VERSION_TYPE, the last byte of AUTOPILOT_VERSION.flight_sw_version.
_STAGES = {0: "dev", 64: "alpha", 128: "beta", 192: "rc", 255: ""}


@dataclass(frozen=True, order=True)
class Version:
    """A version, ordered by numbers; `stage`: dev, alpha, beta, rc, or empty.

    >>> str(Version.parsed("v4.6.2")), Version.parsed("1.18-beta1") > Version(1, 17, 3)
    ('4.6.2', True)
    """

    major: int
    minor: int
    patch: int = 0
    stage: str = ""

    @classmethod
    def parsed(cls, text: str) -> "Version":
        """Raise BadInput if the text is no version."""
        match = _WRITTEN.fullmatch(text.strip())
        if match is None:
            words = f'firmware version: expected one like 4.6 or 1.18.0-beta1, not "{text}"'
            raise BadInput(words, code="unknown-version")
        major, minor, patch, stage = match.groups()
        return cls(int(major), int(minor), int(patch or 0), (stage or "").lower())

    @classmethod
    def of_flight_sw(cls, flight_sw_version: int) -> "Version | None":
        major, minor, patch, stage = flight_sw_version.to_bytes(4, "big")
        return cls(major, minor, patch, _STAGES.get(stage, "")) if flight_sw_version else None

    @property
    def series(self) -> tuple[int, int]:
        return self.major, self.minor

    @property
    def number(self) -> int:
        stage = next(number for number, name in _STAGES.items() if name == self.stage)
        return int.from_bytes(bytes((self.major, self.minor, self.patch, stage)), "big")

    def __str__(self) -> str:
        return f"{self.major}.{self.minor}.{self.patch}" + (f"-{self.stage}" if self.stage else "")
