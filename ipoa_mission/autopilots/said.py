"""What is said of a firmware's version: for which one a mission is checked, and what the figures were measured on."""

from ipoa_mission.autopilots.firmware import firmware, series_known
from ipoa_mission.autopilots.vehicle import Autopilot
from ipoa_mission.autopilots.version import MEASURED, Version


def checked_for(autopilot: Autopilot, version: Version | None) -> str:
    """The firmware whose tables hold, in a few words.

    >>> checked_for(Autopilot.PX4, Version(1, 16))
    'px4 1.16 (measured on 1.17.0)'
    """
    major, minor = firmware(autopilot, version).version.series
    return f"{autopilot} {major}.{minor} (measured on {MEASURED[autopilot]})"


def as_json(autopilot: Autopilot, version: Version | None) -> dict[str, str]:
    """The same for machines, with the source that the table was read in."""
    own = firmware(autopilot, version)
    return {
        "autopilot": str(autopilot),
        "table": f"{own.version.major}.{own.version.minor}",
        "source": own.commit,
        "date": own.date,
        "measured": str(MEASURED[autopilot]),
    }


def vehicle_says(autopilot: Autopilot, version: Version | None) -> str | None:
    """What the user of a vehicle should know of its version; None where it is the one measured.

    >>> vehicle_says(Autopilot.ARDUPILOT, Version(4, 6, 2))
    'measured on 4.7.0-dev; the vehicle says 4.6.2'
    """
    measured, known = MEASURED[autopilot], series_known(autopilot)
    if version is None:
        own = firmware(autopilot)
        return f"measured on {measured}; the vehicle does not say its version: it is taken for {own}"
    if version == measured:
        return None
    words = f"measured on {measured}; the vehicle says {version}"
    if version.series in known:
        return words
    own = firmware(autopilot, version)
    return f"{words}, of which there are no tables: what it takes is judged as {own} does"
