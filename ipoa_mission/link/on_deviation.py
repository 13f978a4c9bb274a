from enum import StrEnum


class OnDeviation(StrEnum):  # apart from its users, which the help of the command must not import
    HOLD = "hold"
    RTL = "rtl"
    REPORT = "report"
