"""A mission that would crash or be refused does not leave the house."""

from collections.abc import Sequence

from ipoa_mission.errors import MissionError
from ipoa_mission.mission.finding import Finding, Severity


class Unsafe(MissionError):
    """The checks found errors; the message has each of them on a line."""


def refuse_errors(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """The warnings among the findings of a check.

    Raises:
        Unsafe: there are errors.
    """
    errors = [finding.message for finding in findings if finding.severity is Severity.ERROR]
    if errors:
        raise Unsafe("\n".join(errors), hint="`ipoa-mission check` looks at a mission without sending it")
    return tuple(findings)
