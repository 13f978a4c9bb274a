"""Hold flown times against the estimate and its interval: a line a flight, as docs/flown-times.csv has them.

    python -m tools.fly.times --plans DIR --flights DIR --rows FILE

Every folder NAME-AUTOPILOT__RUN of the flights has what `fly --json` printed (`fly.json`); its mission is
PLANS/NAME-AUTOPILOT/*.plan. The simulators' ground is level, so landings are timed to the height of home.
"""

import csv
import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

from ipoa_mission.forecast.forecast import estimate
from ipoa_mission.forecast.timing.estimate import Estimate
from ipoa_mission.mission.landing_ground import landing_on
from ipoa_mission.mission.mission_io import read_mission
from ipoa_mission.vehicles.autopilot import autopilot_named, registered
from tools import command_line
from tools.fly.judge import plan_digits


@dataclass(frozen=True)
class Row:
    """A flight from arming to disarming [s]; `items` are those that the vehicle told of, `inside` their intervals."""

    scenario: str
    autopilot: str
    flight: int
    plan: str
    contingency: int
    estimated_s: float
    low_s: float
    high_s: float
    flown_s: float
    estimated_route_s: float
    flown_route_s: float
    items: int
    inside: int

    @property
    def is_inside(self) -> bool:
        """Whether the whole flight took as long as its interval says."""
        return self.low_s <= self.flown_s <= self.high_s


def rows(plans: Path, flights: Path) -> Iterator[Row]:
    """A row for each flight that came to its end."""
    estimates: dict[str, tuple[Path, Estimate]] = {}
    for folder in sorted(path.parent for path in flights.glob("*__*/fly.json")):
        told: dict[str, Any] = json.loads((folder / "fly.json").read_text(encoding="utf-8"))
        name, run = folder.name.split("__")
        scenario, autopilot = name.rsplit("-", 1)
        if not told.get("completed"):
            continue
        if name not in estimates:
            (plan,) = (plans / name).glob("*.plan")
            estimates[name] = plan, estimate(landing_on(read_mission(plan, autopilot_named(autopilot)), 0.0))
        plan, expected = estimates[name]
        done = {item["seq"]: float(item["done_s"]) for item in told["items"]}
        items = [item for item in expected.items if item.seq in done]
        last, end = [item for item in items if item.seq < expected.items[-1].seq][-1], expected.items[-1]
        yield Row(
            scenario=scenario,
            autopilot=autopilot,
            flight=int(run),
            plan=plan_digits(plan),
            contingency=end.command,
            estimated_s=round(end.done_s, 2),
            low_s=round(end.low_s, 2),
            high_s=round(end.high_s, 2),
            flown_s=round(float(told["flown_s"]), 2),
            estimated_route_s=round(last.done_s, 2),
            flown_route_s=round(done[last.seq], 2),
            items=len(items),
            inside=sum(item.low_s <= done[item.seq] <= item.high_s for item in items),
        )


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("--plans", type=Path, required=True)
    parser.add_argument("--flights", type=Path, required=True)
    parser.add_argument("--rows", type=Path, required=True)
    given = parser.parse_args()
    judged = list(rows(given.plans, given.flights))
    with given.rows.open("w", encoding="utf-8", newline="") as lines:
        written = csv.DictWriter(lines, [field.name for field in fields(Row)], lineterminator="\n")
        written.writeheader()
        written.writerows(map(asdict, judged))
    for autopilot in registered():
        own = [row for row in judged if row.autopilot == str(autopilot)]
        flights, items = sum(row.is_inside for row in own), sum(row.inside for row in own)
        print(f"{autopilot}: {flights} of {len(own)} flights, {items} of {sum(row.items for row in own)} items inside")


if __name__ == "__main__":
    main()
