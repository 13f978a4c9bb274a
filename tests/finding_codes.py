"""Findings by severity, code and item, without words."""

from collections.abc import Iterable

from ipoa_mission.finding import Finding


def found(findings: Iterable[Finding]) -> list[str]:
    """Return `error far 2` each."""
    return [" ".join(map(str, (one.severity, one.code, *([] if one.seq is None else [one.seq])))) for one in findings]
