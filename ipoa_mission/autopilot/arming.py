"""Sort an autopilot's arming refusals into passing and lasting reasons."""

import re
from dataclasses import dataclass

NO_MATCH = re.compile(r"(?!)")


@dataclass(frozen=True)
class ArmingWords:
    """Patterns of an autopilot's arming texts; the defaults match nothing.

    `begin`: prefix of each reason. `passing`: reasons that clear by themselves.
    """

    begin: re.Pattern[str] = NO_MATCH
    passing: re.Pattern[str] = NO_MATCH

    def reasons(self, words: str) -> tuple[str, ...]:
        return tuple(one for one in words.split("; ") if self.begin.match(one))

    def lasting(self, words: str) -> tuple[str, ...]:
        return tuple(one for one in self.reasons(words) if not self.passing.search(self.begin.sub("", one, count=1)))


NO_ARMING_WORDS = ArmingWords()
