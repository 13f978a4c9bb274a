"""What a vehicle is ordered when its flight deviates from its forecast."""

from enum import StrEnum


class OnDeviation(StrEnum):
    """What a vehicle is ordered when its flight deviates from the forecast; `report`: nothing."""

    HOLD = "hold"
    RTL = "rtl"
    REPORT = "report"
