from collections.abc import Mapping
from typing import Any

# docs/lab/profiles.md: few stops save most time and energy.
PROFILES: Mapping[str, Mapping[str, Any]] = {
    "delivery": {"cost": {"omega": (0.9, 0.05, 0.05)}},
    "rescue": {"safety_distance": 3.0, "cost": {"omega": (0.3, 0.1, 0.6), "d_safe": 15.0}},
    "endurance": {"cost": {"omega": (0.5, 0.45, 0.05)}, "route": {"tolerance": 8.0}},
}


def with_profile(table: Mapping[str, Any]) -> dict[str, Any]:
    name = table.get("profile")
    return _with_defaults(PROFILES.get(name, {}) if isinstance(name, str) else {}, table)


def _with_defaults(settings: Mapping[str, Any], table: Mapping[str, Any]) -> dict[str, Any]:
    merged = {**settings, **table}
    for key in settings.keys() & table.keys():
        if isinstance(settings[key], Mapping) and isinstance(table[key], Mapping):
            merged[key] = _with_defaults(settings[key], table[key])
    return merged
