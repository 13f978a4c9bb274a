"""Refuse a mission with errors."""

from collections.abc import Sequence
from dataclasses import replace

from ipoa_mission.autopilot.commands import Command
from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.forecast.forecast import Forecast


class Unsafe(MissionError):
    """The checks found errors; the message has one line for each."""


# Errors without `--anyway`.
STRICT_CODES = frozenset({"other-vehicle"})


def strictly(findings: Sequence[Finding], anyway: bool = False) -> tuple[Finding, ...]:
    """Raise `STRICT_CODES` to errors unless `anyway`; errors come first."""
    if anyway:
        return tuple(findings)
    harder = [replace(one, severity=Severity.ERROR) if one.code in STRICT_CODES else one for one in findings]
    return tuple(sorted(harder, key=lambda finding: finding.severity is Severity.WARNING))


def unreadable(error: BadInput) -> Finding:
    return Finding("file-unreadable", Severity.ERROR, None, str(error), error.hint)


def refuse_errors(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """Return the warnings of a check.

    Raises:
        Unsafe: there are errors.
    """
    errors = [finding for finding in strictly(findings) if finding.severity is Severity.ERROR]
    if errors:
        codes = list(dict.fromkeys(error.code for error in errors))
        hints = dict.fromkeys(error.hint for error in errors if error.hint)
        words = "\n".join(f"{error.message} [{error.code}]" for error in errors)
        remedies = tuple(dict.fromkeys(one for error in errors for one in error.remedies))
        raise Unsafe(words, hint="; ".join(hints) or None, remedies=remedies, known={"codes": codes})
    return tuple(findings)


def refuse_unclear_returns(findings: Sequence[Finding], forecast: Forecast) -> None:
    """Refuse a flight with a finding about a planned return.

    Raises:
        Unsafe: a return is not clear.
    """
    if forecast.world.safety.returns != "planned":
        return
    own = {seq for seq, item in enumerate(forecast.mission.items, 1) if item.command == Command.NAV_RETURN_TO_LAUNCH}
    codes = {"return-too-near", "land-too-near"}
    unclear = [one for one in findings if one.code in codes or (one.code == "leg-too-near" and one.seq in own)]
    if unclear:
        hints = dict.fromkeys(
            [*(one.hint for one in unclear if one.hint), '[safety] returns = "warn", to be warned only']
        )
        raise Unsafe("\n".join(one.message for one in unclear), hint="; or ".join(hints))
