"""Waiting times of the link beside an autopilot sixty times as fast as real."""

from collections.abc import Callable

from ipoa_mission.link import connect, conversations, departure, orders, upload

TIMES: tuple[tuple[object, str, object], ...] = (
    (connect, "OTHER_HEARTBEATS_S", 0.1),
    (conversations, "REASON_TIMEOUT_S", 0.05),
    (orders, "PARAMETER_ROUND_S", 0.05),
    (upload, "REVISION_S", 0.05),
    (departure.Departure, "RETRY_S", 0.05),
)


def hurry(patch: Callable[[object, str, object], None] = setattr) -> None:
    for module, name, value in TIMES:
        patch(module, name, value)
