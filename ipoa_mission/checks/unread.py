"""Findings about what the readers of a scenario's files did not take."""

from collections.abc import Iterable, Iterator

from ipoa_mission.finding import Finding, Severity
from ipoa_mission.unread import Unread


def check_unread(things: Iterable[Unread]) -> Iterator[Finding]:
    """An error for each kind of thing that may limit the flight."""
    for thing in things:
        if thing.may_limit:
            yield Finding("not-read", Severity.ERROR, None, thing.words, thing.remedy or None)
