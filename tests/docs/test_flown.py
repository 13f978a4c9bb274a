from pathlib import Path

from tools.fly.judge import read_rows, table

DOCS = Path(__file__).resolve().parents[2] / "docs"
FLOWN = read_rows(DOCS / "flown.csv")


def test_the_documented_table_is_of_the_flights_that_were_judged() -> None:
    assert "\n".join(table(FLOWN)) in (DOCS / "lab" / "flown.md").read_text(encoding="utf-8")


def test_every_flight_kept_what_is_required_and_no_more_fell_short_than_may() -> None:
    assert all(flight.least >= flight.required for flight in FLOWN)
    assert sum(flight.least < flight.kept_90 for flight in FLOWN) <= 0.1 * len(FLOWN)
    assert sum(flight.least < flight.kept_99 for flight in FLOWN) <= 0.01 * len(FLOWN)
