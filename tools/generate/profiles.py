"""Plan three maps under each profile, and update docs/lab/profiles.md and docs/profiles.svg.

    python -m tools.generate.profiles [--seeds 2] [--show]

The cheapest plan of several seeds counts. `--show` prints the tables and writes nothing.
"""

import re
import tomllib
from dataclasses import dataclass

import numpy as np

from ipoa_mission.files import read_text, write_atomically
from ipoa_mission.forecast.forecast import estimate
from ipoa_mission.geometry import Points
from ipoa_mission.planning.plan import Plan
from ipoa_mission.planning.planner import NoPath, plan_path
from ipoa_mission.report.plots import draw_views, write_picture
from ipoa_mission.routing.assemble import assemble
from ipoa_mission.scenario import Scenario
from ipoa_mission.scenario.budget import flight_energy
from ipoa_mission.scenario.profiles import PROFILES
from tools import REPOSITORY, command_line

DOCUMENT = REPOSITORY / "docs" / "lab" / "profiles.md"
MAPS = ("campus", "downtown", "oldtown")  # the first is shown in full
AIRFRAME = {"mass_kg": 2.4, "rotors": 4, "rotor_diameter": 0.33}
HEAD = "| profile | length | turns | climb changes | climbed | least clearance | mean clearance | flight | energy |"


@dataclass(frozen=True)
class Flight:
    """Hold a plan under one profile, with time and energy."""

    path: Points
    row: str
    summary: str


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--show", action="store_true", help="print the tables, write nothing")
    wanted = parser.parse_args()
    names: list[str | None] = [None, *PROFILES]
    found = {map_: {name or "none": fly(map_, name, wanted.seeds) for name in names} for map_ in MAPS}
    whole = "\n".join([HEAD, "|" + "---|" * HEAD[1:].count("|"), *(flight.row for flight in found[MAPS[0]].values())])
    short = "\n".join(["| profile | " + " | ".join(MAPS) + " |", "|" + "---|" * (len(MAPS) + 1), *compared(found)])
    print(whole, short, sep="\n\n")
    if wanted.show:
        return
    paths = {name: flight.path for name, flight in found[MAPS[0]].items()}
    picture = draw_views(under(MAPS[0], None), paths, views=("top", "front"))
    write_picture(picture, DOCUMENT.with_name("profiles.svg"))
    text = read_text(DOCUMENT)
    for mark, table in (("one map", whole), ("all maps", short)):
        text = re.sub(rf"(<!-- {mark} -->\n).*?(<!-- end -->)", rf"\g<1>{table}\n\g<2>", text, count=1, flags=re.DOTALL)
    write_atomically(DOCUMENT, text)


def compared(found: dict[str, dict[str, "Flight"]]) -> list[str]:
    """Return length, time and energy of each profile on every map."""
    return [f"| {name} | " + " | ".join(found[map_][name].summary for map_ in MAPS) + " |" for name in found[MAPS[0]]]


def under(map_: str, profile: str | None) -> Scenario:
    """Return the scenario with a profile in place of its weights and distances, for the same airframe."""
    path = REPOSITORY / "missions" / f"{map_}.toml"
    table = tomllib.loads(read_text(path))
    table.pop("safety_distance", None)
    table.pop("cost", None)
    table["route"] = {"ending": table.get("route", {}).get("ending", "rtl")}
    table["vehicle"] = {**table.get("vehicle", {}), "airframe": AIRFRAME}
    table["vehicle"].pop("battery", None)
    named = {"profile": profile} if profile else {}
    return Scenario.model_validate({"name": path.stem} | table | named, context={"folder": str(path.parent)})


def attempt(scenario: Scenario, seed: int) -> Plan | None:
    """Return the plan of one seed, or None without a path."""
    try:
        return plan_path(scenario, seed=seed)
    except NoPath:
        return None


def fly(map_: str, profile: str | None, seeds: int) -> Flight:
    scenario = under(map_, profile)
    plans = [plan for seed in range(seeds) if (plan := attempt(scenario, seed)) is not None]
    if not plans:
        raise SystemExit(f"{map_}, profile {profile}: no path by any of {seeds} seeds")
    plan = min(plans, key=lambda each: each.cost.total)
    terms = plan.cost
    predicted = estimate(assemble(plan, scenario))
    used = flight_energy(scenario, predicted.track.times, predicted.track.points, predicted.track.speeds)
    assert used is not None
    nodes = plan.curve.sample(2000)
    clear = scenario.airspace.obstacle_distance(nodes) - scenario.vehicle.radius
    climbed = float(np.maximum(np.diff(nodes[:, 2]), 0).sum())
    cells = (
        profile or "none",
        f"{terms.length:.1f} m",
        f"{terms.turning_deg:.0f}°",
        f"{terms.climbing_deg:.0f}°",
        f"{climbed:.1f} m",
        f"{clear.min():.1f} m",
        f"{clear.mean():.1f} m",
        f"{predicted.total_s:.0f} s",
        f"{used.energy_wh:.2f} Wh",
    )
    summary = f"{terms.length:.0f} m, {predicted.total_s:.0f} s, {used.energy_wh:.2f} Wh"
    return Flight(nodes[::4], "| " + " | ".join(cells) + " |", summary)


if __name__ == "__main__":
    main()
