"""The measured distance of PX4's flights from their predicted paths (docs/safety.md)."""

from ipoa_mission.forecast.deviation.law import DeviationLaw, Quantiles

LAW = DeviationLaw(
    level=Quantiles(
        (-1.5, 0.0, 0.12, 0.22, 0.42, 0.62, 1.07, 1.42, 1.72), (1.0, 0.5, 0.3, 0.2, 0.1, 0.05, 0.01, 0.002, 0.0005)
    ),
    down=Quantiles((-2.5, 0.0, 0.75, 1.1, 1.35, 1.75, 2.1), (1.0, 0.5, 0.2, 0.1, 0.05, 0.01, 0.002)),
    up=Quantiles((-2.0, 0.0, 0.55, 1.0, 1.45, 2.1, 2.7), (1.0, 0.5, 0.2, 0.1, 0.05, 0.01, 0.002)),
    lowest=Quantiles((0.0, 0.9, 1.75, 2.0, 2.4), (1.0, 0.5, 0.1, 0.05, 0.01)),
    highest=Quantiles((0.0, 1.0, 2.4, 2.85, 3.2), (1.0, 0.5, 0.1, 0.05, 0.01)),
    farthest=None,
    turn=8.0,
    after_cruise_factor=1.5,
    memory=4.0,
    height_memory=10.0,
    growth=(0.1, 0.03, 0.1),
    source="PX4 1.17 in its simulator (SIH): 92 flights of 21 missions, 1.5 to 18 m/s, and 22 in wind, by true place",
    strongest=6.0,
)
