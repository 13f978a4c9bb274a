"""Choose the order to a vehicle that deviates from its forecast."""

from enum import StrEnum


class OnDeviation(StrEnum):
    """Choose the order; `report`: none."""

    HOLD = "hold"
    RTL = "rtl"
    REPORT = "report"
