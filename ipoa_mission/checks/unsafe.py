"""A mission that would crash or be refused does not leave the house."""

from collections.abc import Sequence
from dataclasses import replace

from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.finding import Finding, Severity
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.mission.commands import Command


class Unsafe(MissionError):
    """The checks found errors; the message has each of them on a line."""


#: Warnings that are errors, unless `--anyway` lets them pass.
STRICT = frozenset({"other-vehicle"})


def strictly(findings: Sequence[Finding], anyway: bool = False) -> tuple[Finding, ...]:
    """Make errors of what only `anyway` lets pass; errors stay before warnings."""
    if anyway:
        return tuple(findings)
    harder = [replace(one, severity=Severity.ERROR) if one.code in STRICT else one for one in findings]
    return tuple(sorted(harder, key=lambda finding: finding.severity is Severity.WARNING))


def unreadable(error: BadInput) -> Finding:
    """Make a finding of a mission file that cannot be read."""
    return Finding("file-unreadable", Severity.ERROR, None, str(error), error.hint)


def refuse_errors(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """The warnings among the findings of a check.

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
    """Refuse a flight with a finding about a return where its scenario has returns planned.

    Raises:
        Unsafe: a return is not clear.
    """
    if forecast.world.safety.returns != "planned":
        return
    own = {seq for seq, item in enumerate(forecast.mission.items, 1) if item.command == Command.NAV_RETURN_TO_LAUNCH}
    codes = {"return-too-near", "land-too-near"}
    told = [one for one in findings if one.code in codes or (one.code == "leg-too-near" and one.seq in own)]
    if told:
        hints = dict.fromkeys([*(one.hint for one in told if one.hint), '[safety] returns = "warn", to be warned only'])
        raise Unsafe("\n".join(one.message for one in told), hint="; or ".join(hints))
