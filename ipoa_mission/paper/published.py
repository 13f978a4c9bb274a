"""Provide the printed Tables 3 to 8 of Biomimetics 2024, 9, 647."""

import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from importlib.resources import files
from typing import Any, TypeAlias, TypeVar

Key = TypeVar("Key", str, int)
Numbers: TypeAlias = tuple[float, ...]
Rows: TypeAlias = dict[str, Numbers]

#: columns of all tables; the paper prints Tables 5 to 8 in another order
ALGORITHMS = ("ipoa", "dbo", "poa", "ssa", "mpoa", "hho")

RIVALS_OF_TABLE_4 = ("dbo", "poa", "ssa", "hho", "mpoa")


@dataclass(frozen=True)
class PrintedTables:
    table_3: dict[str, Rows]  # "best", "mean" and "sd" of the cost
    table_4: Rows  # p against `RIVALS_OF_TABLE_4`
    table_5: dict[int, Rows]  # by experiment
    table_6: dict[int, Rows]  # by map
    table_7: dict[int, Rows]  # by number of obstacles
    table_8: Rows
    improvements: dict[str, Rows]  # on "poa" and "mpoa", by table

    @property
    def improved(self) -> dict[str, tuple[Rows, ...]]:
        return {
            "Table 6": tuple(self.table_6.values()),
            "Table 7, 6 obstacles": (self.table_7[6],),
            "Table 7, 10 obstacles": (self.table_7[10],),
            "Table 8": (self.table_8,),
        }


def _rows(table: dict[str, list[float]]) -> Rows:
    return {name: tuple(numbers) for name, numbers in table.items()}


def _read_tables() -> PrintedTables:
    printed = tomllib.loads(files("ipoa_mission.paper").joinpath("published.toml").read_text(encoding="utf-8"))

    def tables(name: str, key: Callable[[Any], Key]) -> dict[Key, Rows]:
        return {key(part): _rows(table) for part, table in printed[name].items()}

    return PrintedTables(
        table_3=tables("table_3", str),
        table_4=_rows(printed["table_4"]),
        table_5=tables("table_5", int),
        table_6=tables("table_6", int),
        table_7=tables("table_7", int),
        table_8=_rows(printed["table_8"]),
        improvements=tables("improvements", str),
    )


PRINTED = _read_tables()
