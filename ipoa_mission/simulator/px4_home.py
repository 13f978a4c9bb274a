"""How high PX4 believes home to lie: for two minutes after take-off it corrects that by satellite, and by its noise.

Each fix is held against the barometer, which was set to the first fix after take-off. Where the two differ from the
correction in force by more than a metre, and the climb summed up from satellite speeds sides with the barometer, home
moves by the difference; heights above home, and with them every waypoint, move along. The receiver of PX4's simulator
is wrong by half a metre at random, so home jumps by a metre or two, more than once a second (1.17, as recorded).
"""

import random

WINDOW_S = 120.0  # after the take-off is noticed
NOTICED_S = 0.9  # from the end of spooling up until the take-off is noticed (as recorded)
FIX_S = 0.125  # between two fixes
HEIGHT_ERROR = 0.5  # of a fix, standard deviation [m]
CLIMB_ERROR = 0.1  # of a fix's vertical speed, standard deviation [m/s]
THRESHOLD = 1.0  # [m]


class HomeHeight:
    """`shift`: how far above its true place home is believed to be [m]."""

    def __init__(self, chance: random.Random) -> None:
        self.shift = 0.0
        self._chance = chance
        self._since = 0.0
        self._fixes = 0
        self._first = 0.0  # error of the first fix, which the barometer was set to
        self._climbed = 0.0  # error of the climb summed up since then

    def advance(self, dt: float) -> None:
        """Let `dt` pass in the air, or about to be."""
        self._since += dt
        flown = self._since - NOTICED_S
        if not self._fixes * FIX_S <= flown < WINDOW_S:
            return
        error = self._chance.gauss(0.0, HEIGHT_ERROR)
        if self._fixes == 0:
            self._first = error
        self._fixes += 1
        self._climbed += self._chance.gauss(0.0, CLIMB_ERROR) * FIX_S
        off = error - self._first - self.shift  # between the fix, as corrected so far, and the barometer
        sides = abs(self._climbed) < min(abs(off), abs(self._climbed - off))
        if sides and abs(off) > THRESHOLD:
            self.shift += off
