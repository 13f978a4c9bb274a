"""Sort an autopilot's texts that refuse arming into passing and lasting reasons."""

import re
from dataclasses import dataclass

NO_MATCH = re.compile(r"(?!)")


@dataclass(frozen=True)
class ArmingWords:
    """Patterns of an autopilot's arming texts; the defaults match nothing.

    `begin` matches the prefix of each reason. `passing` finds reasons that clear by themselves, such as an unknown
    position.
    """

    begin: re.Pattern[str] = NO_MATCH
    passing: re.Pattern[str] = NO_MATCH

    def reasons(self, words: str) -> tuple[str, ...]:
        """Return the arming reasons in `words`, which are separated by "; "."""
        return tuple(one for one in words.split("; ") if self.begin.match(one))

    def lasting(self, words: str) -> tuple[str, ...]:
        """Return the reasons that do not clear by waiting."""
        return tuple(one for one in self.reasons(words) if not self.passing.search(self.begin.sub("", one, count=1)))


NO_ARMING_WORDS = ArmingWords()
