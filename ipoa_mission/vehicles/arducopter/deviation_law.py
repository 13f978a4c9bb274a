"""The measured distance of ArduCopter's flights from their predicted paths (docs/safety.md)."""

from ipoa_mission.forecast.deviation.law import DeviationLaw, Quantiles

LAW = DeviationLaw(
    level=Quantiles((-0.1, 0.0, 0.02, 0.04, 0.06, 0.12, 0.28, 0.5), (1.0, 0.5, 0.2, 0.1, 0.05, 0.01, 0.002, 0.0005)),
    down=Quantiles((-0.3, 0.0, 0.02, 0.04, 0.1, 0.25), (1.0, 0.5, 0.2, 0.1, 0.01, 0.002)),
    up=Quantiles((-0.1, 0.09, 0.11, 0.13, 0.17, 0.27, 0.43), (1.0, 0.5, 0.2, 0.1, 0.05, 0.01, 0.002)),
    lowest=Quantiles((0.0, 0.05, 0.13, 0.30), (1.0, 0.2, 0.05, 0.01)),
    highest=Quantiles((0.0, 0.05, 0.2, 0.3, 0.65), (1.0, 0.4, 0.1, 0.05, 0.01)),
    farthest=Quantiles((0.0, 0.06, 0.1, 0.17, 0.25, 0.6), (1.0, 0.5, 0.25, 0.1, 0.05, 0.01)),
    turn=4.0,
    after_cruise_factor=1.5,
    memory=2.0,
    height_memory=10.0,
    growth=(0.06, 0.03, 0.1),
    source="ArduCopter 4.7.0-dev in its simulator: 42 flights, 17 of them by its true position, and 25 in wind",
    strongest=8.0,
)
