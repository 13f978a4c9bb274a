"""Provide the printed Tables 3 to 8 of Biomimetics 2024, 9, 647."""

import tomllib
from collections.abc import Callable
from importlib.resources import files
from typing import Any, TypeAlias, TypeVar

Key = TypeVar("Key", str, int)
Numbers: TypeAlias = tuple[float, ...]
Rows: TypeAlias = dict[str, Numbers]

#: columns of all tables; the paper prints Tables 5 to 8 in another order
ALGORITHMS = ("ipoa", "dbo", "poa", "ssa", "mpoa", "hho")

RIVALS_OF_TABLE_4 = ("dbo", "poa", "ssa", "hho", "mpoa")

_PRINT = tomllib.loads(files("ipoa_mission.paper").joinpath("published.toml").read_text(encoding="utf-8"))


def _rows(table: dict[str, list[float]]) -> Rows:
    return {name: tuple(numbers) for name, numbers in table.items()}


def _tables(name: str, key: Callable[[Any], Key]) -> dict[Key, Rows]:
    return {key(of): _rows(table) for of, table in _PRINT[name].items()}


#: "best", "mean" and "sd" of the cost; p values against `RIVALS_OF_TABLE_4`
TABLE_3, TABLE_4 = _tables("table_3", str), _rows(_PRINT["table_4"])
#: by experiment
TABLE_5 = _tables("table_5", int)
#: by map, and by number of obstacles
TABLE_6, TABLE_7 = _tables("table_6", int), _tables("table_7", int)
TABLE_8 = _rows(_PRINT["table_8"])
#: on "poa" and "mpoa", by table
IMPROVEMENTS = _tables("improvements", str)

#: rows averaged in those claims
IMPROVED: dict[str, tuple[Rows, ...]] = {
    "Table 6": tuple(TABLE_6.values()),
    "Table 7, 6 obstacles": (TABLE_7[6],),
    "Table 7, 10 obstacles": (TABLE_7[10],),
    "Table 8": (TABLE_8,),
}
