"""Read and write docs/link/uploads.csv, one upload a row."""

import csv
from dataclasses import asdict, dataclass, fields
from pathlib import Path

from ipoa_mission.autopilot.autopilot import Autopilot, autopilot_named

CLIENTS = ("ours", "by-file", "mavsdk", "mavproxy")


@dataclass(frozen=True)
class Cell:
    """Define one client with one autopilot over one radio."""

    autopilot: Autopilot
    delay_ms: float  # one way
    loss_percent: float  # each way
    client: str


@dataclass(frozen=True)
class Run:
    """Record an upload: the client's result, the autopilot's items, time and bytes."""

    autopilot: str
    delay_ms: float
    loss_percent: float
    client: str
    seed: int
    said: bool
    exact: bool
    near: bool  # off by one unit of 1e-7 degree
    seconds: float
    verified_s: float | None
    bytes: int

    @property
    def cell(self) -> Cell:
        return Cell(autopilot_named(self.autopilot), self.delay_ms, self.loss_percent, self.client)


def read_rows(path: Path) -> list[Run]:
    if not path.exists():
        return []
    with path.open(newline="") as file:
        return [
            Run(
                row["autopilot"],
                float(row["delay_ms"]),
                float(row["loss_percent"]),
                row["client"],
                int(row["seed"]),
                row["said"] == "True",
                row["exact"] == "True",
                row["near"] == "True",
                float(row["seconds"]),
                float(row["verified_s"]) if row["verified_s"] else None,
                int(row["bytes"]),
            )
            for row in csv.DictReader(file)
        ]


def add_row(path: Path, done: Run) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    is_new = not path.exists()
    with path.open("a", newline="") as file:
        writer = csv.DictWriter(file, [field.name for field in fields(Run)], lineterminator="\n")
        if is_new:
            writer.writeheader()
        writer.writerow(asdict(done))
