"""Test whether flights keep their promised clearance: plan random scenes, and fly each many times.

    python -m tools.benchmarks.promise [--scenes 50] [--flights 20] [--autopilot px4]

Each scene is planned at the scenario's confidence, and flown on the built-in autopilot. The vehicle's true position
counts from the end of the take-off to the last waypoint. For 50, 90 and 99 % a binomial test compares the number of
flights below the promised clearance with the number allowed.
"""

import numpy as np
from rich.progress import track
from scipy.stats import binomtest

from ipoa_mission.autopilot.autopilot import Autopilot, autopilot_named
from ipoa_mission.errors import MissionError
from ipoa_mission.flight.flight import Flight, plan_flight
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.geometry import Points
from ipoa_mission.mission.items import Mission
from ipoa_mission.scenario import Scenario
from ipoa_mission.simulator.simulated_flight import MissionState, SimulatedFlight
from tools import command_line

LEVELS = (0.5, 0.9, 0.99)
LONGEST_S = 600.0
LOOK_S = 0.1


def scene(number: int, autopilot: Autopilot) -> Scenario:
    """Return nine to sixteen masts and boxes in 160 x 120 m, and a path through them."""
    rng = np.random.default_rng([2026, number])
    obstacles = []
    for n in range(int(rng.integers(9, 17))):
        where = {"name": f"{n}", "east": float(rng.uniform(15, 125)), "north": float(rng.uniform(-55, 55))}
        if n % 2:
            shape = {"kind": "cylinder", "radius": float(rng.uniform(1, 6)), "height": float(rng.uniform(20, 60))}
        else:
            size = {"width": float(rng.uniform(5, 16)), "depth": float(rng.uniform(5, 16))}
            shape = {"kind": "box", **size, "height": float(rng.uniform(15, 50))}
        obstacles.append({**shape, **where})
    return Scenario.model_validate(
        {
            "home": {"latitude_deg": 47.397742, "longitude_deg": 8.545594, "altitude_amsl": 488.0},
            "start": {"east": 0.0, "north": 0.0, "up": float(rng.uniform(10, 20))},
            "goal": {"east": 140.0, "north": float(rng.uniform(-30, 30)), "up": float(rng.uniform(10, 25))},
            "bounds": {"east": (-30.0, 170.0), "north": (-70.0, 70.0), "up": (0.0, 80.0)},
            "safety_distance": 1.5,
            "vehicle": {"autopilot": str(autopilot), "radius": 0.5, "cruise_speed": float(rng.uniform(4, 9))},
            "route": {"ending": "land"},
            "obstacles": obstacles,
        }
    )


def flown(mission: Mission, seed: int) -> Points:
    """Return places (n, 3) [m] from the end of the take-off to the last waypoint."""
    vehicle = SimulatedFlight(mission.autopilot, mission.home, mission.parameters, seed=seed)
    vehicle.load(mission.items)
    vehicle.arm()
    vehicle.start()
    places = []
    while vehicle.mission_state is not MissionState.COMPLETE and vehicle.time_s < LONGEST_S:
        vehicle.advance(vehicle.time_s + LOOK_S)
        if 0 < vehicle.current < len(mission.items) - 1:
            places.append(vehicle.local)
    return np.array(places)


def kept_at(flight: Flight, level: float) -> float:
    """Return the clearance [m] that a share `level` of flights must keep."""
    safety = flight.scenario.safety.model_copy(update={"confidence": level})
    promise = Forecast(flight.mission, flight.scenario.model_copy(update={"safety": safety})).promise
    return min((one.kept for one in promise.limits if one.limit == "obstacles" and one.on_the_way), default=np.inf)


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("--scenes", type=int, default=50)
    parser.add_argument("--flights", type=int, default=20)
    parser.add_argument("--autopilot", type=autopilot_named, default=Autopilot.PX4)
    given = parser.parse_args()
    short, below, count, refused = dict.fromkeys(LEVELS, 0), 0, 0, 0
    for number in track(range(given.scenes)):
        scenario = scene(number, given.autopilot)
        try:
            flight = plan_flight(scenario)
        except MissionError:
            refused += 1
            continue
        kept = {level: kept_at(flight, level) for level in LEVELS}
        for seed in range(given.flights):
            least = scenario.airspace.obstacle_clearance(flown(flight.mission, 1000 * number + seed)).distance
            count += 1
            below += least < scenario.limits.obstacle_distance
            for level in LEVELS:
                short[level] += least < kept[level]
    print(f"{given.autopilot}: {given.scenes - refused} scenes planned, {refused} refused, {count} flights")
    print(f"nearer than required: {below}")
    for level in LEVELS:
        chance = binomtest(short[level], count, 1 - level, "greater").pvalue if count else np.nan
        print(f"short of what {level:.0%} keep: {short[level]} ({short[level] / max(count, 1):.1%}), p = {chance:.2f}")


if __name__ == "__main__":
    main()
