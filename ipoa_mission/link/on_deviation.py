from enum import StrEnum


class OnDeviation(StrEnum):
    HOLD = "hold"
    RTL = "rtl"
    REPORT = "report"
