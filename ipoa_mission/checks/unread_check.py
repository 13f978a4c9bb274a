"""Report content of a scenario's files that the readers skipped."""

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from ipoa_mission.checks.firmware_check import expect_measured
from ipoa_mission.checks.unsafe import refuse_errors
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.unread import Unread

if TYPE_CHECKING:
    from ipoa_mission.scenario import Scenario

IGNORE_HINT = 'if it limits no flight: --ignore not-read, or [safety] ignore = ["not-read"]'


def check_unread(things: Iterable[Unread]) -> Iterator[Finding]:
    for thing in things:
        if thing.may_limit:
            hint = "; ".join(filter(None, (thing.remedy, IGNORE_HINT)))
            yield Finding("not-read", Severity.ERROR, None, thing.words, hint)


def refuse_unread(scenario: "Scenario | None") -> None:
    """Raise Unsafe if unread content may limit the flight, and the scenario does not ignore it."""
    if scenario is not None and "not-read" not in scenario.safety.ignored:
        refuse_errors([*check_unread(scenario.unread)])


def expect_plannable(scenario: "Scenario") -> None:
    """Raise Unsafe if the version was not measured, or content that may limit the flight was not read."""
    expect_measured(scenario)
    refuse_unread(scenario)
