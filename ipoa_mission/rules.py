"""Codes of the findings of `check`; docs/findings.md has the meaning of each, and advice."""

from collections.abc import Iterable, Mapping

from ipoa_mission.errors import BadInput, UnknownName, hint_of

#: by code, whether a crash may follow: then it is never ignored
RULES: Mapping[str, bool] = {
    **dict.fromkeys((
        "home-place", "home-unknown", "home-altitude", "home-differs", "home-not-on-ground", "another-place",
        "position-out-of-range", "position-missing", "position-here", "too-far", "altitude-missing",
        "altitude-kept", "height-over-terrain", "height-absurd", "below-home", "frame-not-taken",
        "frame-without-place", "jump-flown-elsewhere", "takeoff-not-first", "takeoff-low", "ends-in-the-air",
        "rally-place", "rally-height", "fence-place", "outside-fence", "leg-too-near", "flights-too-near",
        "return-too-near", "land-too-near", "battery-short", "battery-no-return",
        "way-unknown", "never-reached", "map-not-understood", "fast-touchdown", "wind-too-strong",
        "version-not-measured", "waypoint-passed", "file-unreadable", "file-parameters"
    ), True),
    **dict.fromkeys((
        "home-elsewhere", "far", "empty", "too-many", "command-not-taken", "command-never-flown",
        "command-of-development", "param-refused", "param-too-large", "fence-refused", "hold", "hold-rounded",
        "speed", "jump-target", "jump-without-end", "jump-repeats", "jump-no-way-on", "jump-tag-twice",
        "too-many-jumps", "waits-for-someone", "behind-landing", "fence-off", "waits-until-clock",
        "action-at-other-time", "takeoff-missing", "ends-refused", "disarms-waiting", "terrain-data",
        "terrain-clearance", "fence-shape", "battery-unsure", "circle-sense", "not-read",
        "slow-landing", "wind-not-measured", "waypoint-may-be-passed", "no-aircraft", "other-vehicle", "file",
        "file-home", "file-numbers"
    ), False),
}  # fmt: skip


def expect_ignorable(codes: Iterable[str]) -> frozenset[str]:
    """Raise BadInput if a code is unknown, or a crash may follow from its finding."""
    chosen = tuple(codes)
    for code in chosen:
        if code not in RULES:
            raise UnknownName("expected the code of a finding", hint=hint_of(code, RULES), place=code)
        if RULES[code]:
            raise BadInput("expected a code that may be ignored: a crash may follow from this finding", place=code)
    return frozenset(chosen)
