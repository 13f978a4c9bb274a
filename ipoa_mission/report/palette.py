"""Colors that color-blind readers can distinguish: Okabe and Ito's for paths, quiet ones for the world.

Source: M. Okabe and K. Ito, Color Universal Design, jfly.uni-koeln.de/color (2008). Paths also differ by their
markers, so that a gray print can be read.
"""

BLACK = "#000000"
ORANGE = "#E69F00"
SKY_BLUE = "#56B4E9"
BLUISH_GREEN = "#009E73"
BLUE = "#0072B2"
VERMILLION = "#D55E00"
REDDISH_PURPLE = "#CC79A7"

#: In the order of paths and curves; yellow is left out, because it is hard to see on white.
PATHS = (BLUE, VERMILLION, BLUISH_GREEN, REDDISH_PURPLE, ORANGE, SKY_BLUE, BLACK)
MARKERS = ("o", "s", "^", "D", "v", "P", "X")

LOW_GROUND = "#EFEBE1"
HIGH_GROUND = "#B5A98F"
LOW_ROOF = "#C5CCD4"
HIGH_ROOF = "#7D8A99"
OUTLINE = "#4A545F"
