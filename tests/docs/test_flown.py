import csv
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from statistics import mean

DOCS = Path(__file__).resolve().parents[2] / "docs"
COLUMNS = "scenario | flights | estimated s | flown s | mean | required m | nominal m | 99 % keep m | least flown m"
NAMES = {"ardupilot": "ArduCopter", "px4": "PX4"}
with (DOCS / "flown.csv").open(encoding="utf-8", newline="") as file:
    FLOWN = list(csv.DictReader(file))


def table() -> Iterator[str]:
    """Yield a Markdown line for each scenario and autopilot."""
    yield f"| {COLUMNS} |"
    yield f"|{'---|' * 9}"
    groups = defaultdict(list)
    for row in FLOWN:
        groups[row["autopilot"], row["scenario"]].append(row)
    for (autopilot, scenario), group in sorted(groups.items()):
        estimated, flown = float(group[0]["estimated_s"]), [float(row["flown_s"]) for row in group]
        cells = (
            f"{scenario}, {NAMES[autopilot]}",
            str(len(group)),
            f"{estimated:.1f}",
            f"{min(flown):.1f} to {max(flown):.1f}",
            f"{100 * (estimated / mean(flown) - 1):+.1f} %",
            *(f"{float(group[0][name]):.2f}" for name in ("required", "nominal", "kept_99")),
            f"{min(float(row['least']) for row in group):.2f}",
        )
        yield f"| {' | '.join(cells)} |"


def nearer_than(name: str) -> int:
    return sum(float(row["least"]) < float(row[name]) for row in FLOWN)


def test_the_documented_table_is_of_the_flights_that_were_judged() -> None:
    assert "\n".join(table()) in (DOCS / "lab" / "flown.md").read_text(encoding="utf-8")


def test_every_flight_kept_what_is_required_and_no_more_fell_short_than_may() -> None:
    assert nearer_than("required") == 0
    assert nearer_than("kept_90") <= 0.1 * len(FLOWN)
    assert nearer_than("kept_99") <= 0.01 * len(FLOWN)
