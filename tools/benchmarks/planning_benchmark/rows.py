"""Store measurements as rows of a CSV file; a new row replaces the one with its key."""

import csv
import datetime
import io
from collections.abc import Iterator
from dataclasses import asdict, dataclass, fields
from pathlib import Path

from ipoa_mission.files import read_text, write_atomically


@dataclass(frozen=True)
class Row:
    """Record one run: part, map, method, setting and seed.

    `cost` and `length_m` are those of the path, empty without one; `safe`: proved to keep every limit; `cpu_s` after
    warm-up.
    """

    part: str
    map: str
    method: str
    setting: str
    seed: int
    cost: float | None
    length_m: float | None
    safe: bool
    cpu_s: float
    versions: str
    date: str

    @property
    def key(self) -> tuple[str, str, str, str, int]:
        return self.part, self.map, self.method, self.setting, self.seed


def today() -> str:
    return datetime.datetime.now(tz=datetime.UTC).date().isoformat()


def read_rows(path: Path) -> list[Row]:
    """Return the rows of a file; none if it does not exist."""
    return list(_parse(read_text(path))) if path.exists() else []


def add_row(path: Path, row: Row) -> None:
    rows = {old.key: old for old in read_rows(path)} | {row.key: row}
    out = io.StringIO()
    writer = csv.DictWriter(out, [field.name for field in fields(Row)], lineterminator="\n")
    writer.writeheader()
    for each in rows.values():
        table = asdict(each)
        for name, digits in (("cost", 3), ("length_m", 2), ("cpu_s", 3)):
            table[name] = "" if table[name] is None else f"{table[name]:.{digits}f}"
        writer.writerow(table | {"safe": "yes" if each.safe else "no"})
    write_atomically(path, out.getvalue())


def _parse(text: str) -> Iterator[Row]:
    for line in csv.DictReader(io.StringIO(text)):
        yield Row(
            part=line["part"],
            map=line["map"],
            method=line["method"],
            setting=line["setting"],
            seed=int(line["seed"]),
            cost=float(line["cost"]) if line["cost"] else None,
            length_m=float(line["length_m"]) if line["length_m"] else None,
            safe=line["safe"] == "yes",
            cpu_s=float(line["cpu_s"]),
            versions=line["versions"],
            date=line["date"],
        )
