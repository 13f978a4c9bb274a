from enum import StrEnum


class Color(StrEnum):
    """The first seven for color-blind readers: M. Okabe and K. Ito, jfly.uni-koeln.de/color (2008)."""

    BLACK = "#000000"
    ORANGE = "#E69F00"
    SKY_BLUE = "#56B4E9"
    BLUISH_GREEN = "#009E73"
    BLUE = "#0072B2"
    VERMILLION = "#D55E00"
    REDDISH_PURPLE = "#CC79A7"
    LOW_GROUND = "#EFEBE1"
    HIGH_GROUND = "#B5A98F"
    LOW_ROOF = "#C5CCD4"
    HIGH_ROOF = "#7D8A99"
    OUTLINE = "#4A545F"
