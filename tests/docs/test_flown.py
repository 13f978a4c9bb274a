import csv
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from statistics import mean, median

DOCS = Path(__file__).resolve().parents[2] / "docs"
COLUMNS = (
    "autopilot | plans | flights | estimate off the mean, median | worst | nearer than required | below 99 % keep "
    "| below 90 % keep | least surplus over required m | over 99 % keep m"
)
NAMES = {"ardupilot": "ArduCopter 4.7.0-dev", "px4": "PX4 1.17.0"}
with (DOCS / "data" / "flown.csv").open(encoding="utf-8", newline="") as file:
    FLOWN = list(csv.DictReader(file))


def table() -> Iterator[str]:
    """Yield a Markdown line for each autopilot."""
    yield f"| {COLUMNS} |"
    yield f"|{'---|' * 10}"
    for autopilot, name in NAMES.items():
        plans = defaultdict(list)
        for row in FLOWN:
            if row["autopilot"] == autopilot:
                plans[row["scenario"]].append(row)
        flights = [row for group in plans.values() for row in group]
        errors = [
            float(group[0]["estimated_s"]) / mean(float(row["flown_s"]) for row in group) - 1
            for group in plans.values()
        ]
        cells = (
            name,
            str(len(plans)),
            str(len(flights)),
            f"{100 * median(map(abs, errors)):.1f} %",
            f"{100 * max(map(abs, errors)):.1f} %",
            *(str(nearer_than(limit, flights)) for limit in ("required", "kept_99", "kept_90")),
            *(
                f"{min(float(row['least']) - float(row[limit]) for row in flights):.2f}"
                for limit in ("required", "kept_99")
            ),
        )
        yield f"| {' | '.join(cells)} |"


def nearer_than(name: str, flights: list[dict[str, str]]) -> int:
    return sum(float(row["least"]) < float(row[name]) for row in flights)


def test_the_documented_table_is_of_the_flights_that_were_judged() -> None:
    assert "\n".join(table()) in (DOCS / "lab" / "flown.md").read_text(encoding="utf-8")


def test_every_flight_keeps_the_required_clearance_and_few_fall_below_99() -> None:
    assert nearer_than("required", FLOWN) == 0
    assert nearer_than("kept_90", FLOWN) <= 0.1 * len(FLOWN)
    assert nearer_than("kept_99", FLOWN) <= 0.01 * len(FLOWN)
