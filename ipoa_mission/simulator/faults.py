"""Links that lose, duplicate, delay and reorder frames."""

import heapq
import math
import random
from dataclasses import dataclass
from typing import Generic, TypeVar

from ipoa_mission.errors import BadInput


@dataclass(frozen=True)
class Faults:
    """Faults of a link, for each frame in each direction.

    Attributes:
        loss: probability that a frame is lost.
        duplicate: probability that it arrives twice.
        delay_s: one-way delay [s].
        reorder: probability that it is held back.
        reorder_s: longest time of that [s].

    Raises:
        BadInput: a probability is not from 0 to 1, or a time not from 0 to 60 s.

    Example:
        >>> Faults(loss=0.1, delay_s=0.2).duplicate
        0.0
    """

    loss: float = 0.0
    duplicate: float = 0.0
    delay_s: float = 0.0
    reorder: float = 0.0
    reorder_s: float = 0.2

    def __post_init__(self) -> None:
        for name in ("loss", "duplicate", "reorder"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise BadInput(f"expected a probability from 0 to 1, not {getattr(self, name)}", place=name)
        for name in ("delay_s", "reorder_s"):
            if not 0.0 <= getattr(self, name) < 60.0:
                raise BadInput(f"expected 0 to 60 seconds, not {getattr(self, name)}", place=name)


PERFECT = Faults()


T = TypeVar("T")


class Pipe(Generic[T]):
    """One direction; the same seed gives the same faults."""

    MAX_QUEUED = 100_000

    def __init__(self, faults: Faults, seed: int) -> None:
        self._faults = faults
        self._random = random.Random(seed)
        self._queue: list[tuple[float, int, T]] = []
        self._pushed = 0

    def push(self, data: T, now: float) -> None:
        faults = self._faults
        chance = self._random.random
        for _ in range(2 if chance() < faults.duplicate else 1):
            lost = chance() < faults.loss
            late = chance() * faults.reorder_s if chance() < faults.reorder else 0.0
            if not lost and len(self._queue) < self.MAX_QUEUED:
                self._pushed += 1
                heapq.heappush(self._queue, (now + faults.delay_s + late, self._pushed, data))

    def pop(self, now: float) -> list[T]:
        arrived = list[T]()
        while self._queue and self._queue[0][0] <= now:
            arrived.append(heapq.heappop(self._queue)[2])
        return arrived

    @property
    def deadline(self) -> float:
        return self._queue[0][0] if self._queue else math.inf
