"""Whether a flight landed on the ground that its mission knows of: a simulator's may be as high as home everywhere."""

from ipoa_mission.items import Mission
from ipoa_mission.link.logbook import FlightRecord
from ipoa_mission.mission.landing_ground import landing_ground, landing_on
from ipoa_mission.timing.estimate import estimate
from ipoa_mission.wind import Wind

NOTICED = 1.0  # [m]


def landed_elsewhere(mission: Mission, record: FlightRecord, wind: Wind) -> tuple[str, ...]:
    """Words about a landing that was higher or lower than the ground is there, and how long that is estimated to take.

    `wind` is that of the estimate. Nothing where the flight did not land or came down where it should.
    """
    expected = landing_ground(mission)
    if expected is None or not record.completed or not record.path:
        return ()
    landed = round(record.path[-1].height, 1) + 0.0
    if abs(landed - expected) < NOTICED:
        return ()
    other = estimate(landing_on(mission, landed), wind=wind).total_s
    return (
        f"it landed {landed:.1f} m above home, but the ground there is {abs(expected - landed):.1f} m "
        f"{'higher' if expected > landed else 'lower'}: a simulator whose ground is level? `mock --scenario` has the "
        f"scenario's. To where it landed {other:.1f} s are estimated",
    )
