"""Why an autopilot cannot be armed, in its own words: which of its reasons pass with time, and which do not."""

import re
from dataclasses import dataclass

NOTHING = re.compile(r"(?!)")


@dataclass(frozen=True)
class ArmingWords:
    """How an autopilot gives its reasons; the default is one that gives none.

    `begin`: what stands before each reason; `passing`: what is found in those that pass by themselves, as a position
    that is not yet known. All others are for somebody to mend.
    """

    begin: re.Pattern[str] = NOTHING
    passing: re.Pattern[str] = NOTHING

    def reasons(self, words: str) -> tuple[str, ...]:
        """What of its words (several, between them "; ") says why it cannot be armed."""
        return tuple(one for one in words.split("; ") if self.begin.match(one))

    def lasting(self, words: str) -> tuple[str, ...]:
        """Those of its reasons that waiting does not mend."""
        return tuple(one for one in self.reasons(words) if not self.passing.search(self.begin.sub("", one, count=1)))


UNTOLD = ArmingWords()
