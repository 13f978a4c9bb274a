"""What checks found, in short: tests ask for the severity, the code and the item, and not for words."""

from collections.abc import Iterable

from ipoa_mission.finding import Finding


def found(findings: Iterable[Finding]) -> list[str]:
    """`error far 2` each; an item only where one is meant."""
    return [" ".join(map(str, (one.severity, one.code, *([] if one.seq is None else [one.seq])))) for one in findings]
