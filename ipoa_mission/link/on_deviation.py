"""Name what a vehicle is ordered when its flight deviates from its forecast."""

from enum import StrEnum


class OnDeviation(StrEnum):
    """Name what is ordered; `report`: nothing."""

    HOLD = "hold"
    RTL = "rtl"
    REPORT = "report"
