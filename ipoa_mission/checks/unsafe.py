"""A mission that would crash or be refused does not leave the house."""

from collections.abc import Sequence

from ipoa_mission.errors import MissionError
from ipoa_mission.finding import Finding, Severity


class Unsafe(MissionError):
    """The checks found errors; the message has each of them on a line."""


def refuse_errors(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """The warnings among the findings of a check.

    Raises:
        Unsafe: there are errors.
    """
    errors = [finding for finding in findings if finding.severity is Severity.ERROR]
    if errors:
        codes = list(dict.fromkeys(error.code for error in errors))
        hints = dict.fromkeys(error.hint for error in errors if error.hint)
        unsafe = Unsafe("\n".join(f"{error.message} [{error.code}]" for error in errors), hint="; ".join(hints) or None)
        unsafe.known = {"codes": codes}
        raise unsafe
    return tuple(findings)
