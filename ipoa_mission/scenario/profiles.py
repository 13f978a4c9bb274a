"""Named settings for a task: `profile = "rescue"` sets weights and distances; what the file says itself wins."""

from collections.abc import Mapping
from typing import Any

#: Profile -> the tables and keys of a scenario that it sets. The paper's own weights are those without a profile.
#: Measured in docs/lab/profiles.md: what saves time and energy most is not to stop, so that waypoints are few.
PROFILES: Mapping[str, Mapping[str, Any]] = {
    "delivery": {"cost": {"omega": (0.9, 0.05, 0.05)}},
    "rescue": {"safety_distance": 3.0, "cost": {"omega": (0.3, 0.1, 0.6), "d_safe": 15.0}},
    "endurance": {"cost": {"omega": (0.5, 0.45, 0.05)}, "route": {"tolerance": 8.0}},
}


def with_profile(table: Mapping[str, Any]) -> dict[str, Any]:
    """A scenario's table with the settings of its profile, if it names a known one, beneath its own."""
    name = table.get("profile")
    return _beneath(PROFILES.get(name, {}) if isinstance(name, str) else {}, table)


def _beneath(settings: Mapping[str, Any], table: Mapping[str, Any]) -> dict[str, Any]:
    merged = {**settings, **table}
    for key in settings.keys() & table.keys():
        if isinstance(settings[key], Mapping) and isinstance(table[key], Mapping):
            merged[key] = _beneath(settings[key], table[key])
    return merged
