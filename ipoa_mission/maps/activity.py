"""Active times of zones (ED-269, ED-318), seconds since 1970 (UTC)."""

import json
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

DAYS = ("MON", "TUE", "WED", "THU", "FRI", "SAT", "SUN")
EPOCH_WEEKDAY = 3  # a Thursday
DAY_S = 86_400.0
# Assumed longest flight [s].
FLIGHT_S = 3_600.0
_OFFSET = r"(?P<offset>Z|[+-]\d\d:?\d\d)"
_CLOCK = re.compile(rf"(?P<h>\d\d):(?P<m>\d\d)(?::(?P<s>\d\d)(?:\.\d+)?)?{_OFFSET}", re.IGNORECASE)
_DATE = re.compile(r"(?P<date>\d{4}-\d\d-\d\d)T(?P<clock>.*)", re.IGNORECASE)


@dataclass(frozen=True)
class Slot:
    """Seconds from midnight UTC on weekdays (0: Monday), maybe into the next day."""

    days: frozenset[int]
    begin: float
    end: float


@dataclass(frozen=True)
class Period:
    begin: float = -math.inf
    end: float = math.inf
    slots: tuple[Slot, ...] = ()

    def meets(self, begin: float, end: float) -> bool:
        begin, end = max(begin, self.begin), min(end, self.end)
        if begin > end or not self.slots:
            return begin <= end
        days = range(math.floor(begin / DAY_S) - 2, math.floor(end / DAY_S) + 3)
        return any(
            (day + EPOCH_WEEKDAY) % 7 in slot.days
            and day * DAY_S + slot.begin <= end
            and day * DAY_S + slot.end >= begin
            for slot in self.slots
            for day in days
        )


def periods_of(tags: Mapping[str, str]) -> tuple[Period, ...] | None:
    """Read `limitedApplicability`; None: always active or unreadable.

    >>> periods_of({"limitedApplicability": '[{"endDateTime": "1970-01-02T01:00:00+01:00"}]'})
    (Period(begin=-inf, end=86400.0, slots=()),)
    """
    try:
        periods = tuple(_period(each) for each in json.loads(tags.get("limitedApplicability", "null")))
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        return None
    return periods or None


def may_be_active(tags: Mapping[str, str], time: float) -> bool:
    periods = periods_of(tags)
    return periods is None or any(period.meets(time, time + FLIGHT_S) for period in periods)


def _period(given: Mapping[str, Any]) -> Period:
    ends = [given.get(key) for key in ("startDateTime", "endDateTime")]
    begin, end = (
        default if each is None else _instant(each) for each, default in zip(ends, (-math.inf, math.inf), strict=True)
    )
    return Period(begin, end, tuple(_slots(given.get("schedule") or [])))


def _slots(schedule: Any) -> Iterator[Slot]:
    for one in schedule:
        named = one.get("day") or ["ANY"]
        listed = [DAYS.index(day) for day in named if day in DAYS]
        days = frozenset(listed if len(listed) == len(named) else range(7))  # "ANY", or a holiday of unknown date
        if "startTime" in one and "endTime" in one:
            begin, end = _clock(one["startTime"]), _clock(one["endTime"])
            yield Slot(days, begin, end if end > begin else end + DAY_S)
        else:  # dawn or dusk
            yield Slot(days, -DAY_S / 2, 1.5 * DAY_S)


def _instant(text: str) -> float:
    match = _DATE.fullmatch(text)
    if match is None:
        raise ValueError(text)
    day = np.datetime64(match["date"], "D").astype(int)
    return float(day) * DAY_S + _clock(match["clock"])


def _clock(text: str) -> float:
    match = _CLOCK.fullmatch(text)
    if match is None:
        raise ValueError(text)
    offset = match["offset"].upper().replace(":", "")
    east = 0 if offset == "Z" else int(offset[0] + "1") * (int(offset[1:3]) * 3600 + int(offset[3:5]) * 60)
    return int(match["h"]) * 3600.0 + int(match["m"]) * 60 + int(match["s"] or 0) - east
