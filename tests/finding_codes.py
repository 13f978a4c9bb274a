"""Findings by severity, code and item, without words."""

from collections.abc import Iterable

from ipoa_mission.finding import Finding


def codes_of(findings: Iterable[Finding]) -> list[str]:
    """Return `error far 2` each."""
    return [" ".join(map(str, (f.severity, f.code, *([] if f.seq is None else [f.seq])))) for f in findings]
