"""What a check has to say about an item."""

from ipoa_mission.finding import Finding, Severity
from ipoa_mission.mission.commands import command_name
from ipoa_mission.mission.items import Item

__all__ = ["Finding", "Severity", "error", "warning"]


def error(code: str, seq: int, item: Item, message: str, hint: str | None = None) -> Finding:
    """An error about an item."""
    return Finding(code, Severity.ERROR, seq, f"item {seq} ({command_name(item.command)}): {message}", hint)


def warning(code: str, seq: int, item: Item, message: str) -> Finding:
    """A warning about an item."""
    return Finding(code, Severity.WARNING, seq, f"item {seq} ({command_name(item.command)}): {message}")
