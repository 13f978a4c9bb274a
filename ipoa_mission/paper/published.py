"""Provide the printed Tables 3 to 8 of Biomimetics 2024, 9, 647, from `published.toml`.

Every row has one number for each algorithm, in the order of `ALGORITHMS`.
"""

import tomllib
from collections.abc import Callable
from importlib.resources import files
from typing import Any, TypeAlias, TypeVar

Key = TypeVar("Key", str, int)
Numbers: TypeAlias = tuple[float, ...]
#: A table's rows by name.
Rows: TypeAlias = dict[str, Numbers]

#: The columns of Tables 3 and 5 to 8 by this package's names. Tables 5 to 8 print them in another order; here all
#: tables have this one.
ALGORITHMS = ("ipoa", "dbo", "poa", "ssa", "mpoa", "hho")

#: The columns of Table 4: IPOA's rivals.
RIVALS_OF_TABLE_4 = ("dbo", "poa", "ssa", "hho", "mpoa")

_PRINT = tomllib.loads(files("ipoa_mission.paper").joinpath("published.toml").read_text(encoding="utf-8"))


def _rows(table: dict[str, list[float]]) -> Rows:
    return {name: tuple(numbers) for name, numbers in table.items()}


def _tables(name: str, key: Callable[[Any], Key]) -> dict[Key, Rows]:
    return {key(of): _rows(table) for of, table in _PRINT[name].items()}


#: CEC2022 by function: "best", "mean" and "sd" of the cost; p values against each of `RIVALS_OF_TABLE_4`.
TABLE_3, TABLE_4 = _tables("table_3", str), _rows(_PRINT["table_4"])
#: Cost by the experiment's number: "best", "mean" and "sd".
TABLE_5 = _tables("table_5", int)
#: By map number, and by number of obstacles: "distance", "iterations", "turn" and "dis_obs".
TABLE_6, TABLE_7 = _tables("table_6", int), _tables("table_7", int)
#: The campus: "distance", "turn", "dis_obs" and "time".
TABLE_8 = _rows(_PRINT["table_8"])
#: Improvements on "poa" and "mpoa" claimed in the text, by the table that it refers to.
IMPROVEMENTS = _tables("improvements", str)

#: Rows of the tables that those claims refer to, to be averaged.
IMPROVED: dict[str, tuple[Rows, ...]] = {
    "Table 6": tuple(TABLE_6.values()),
    "Table 7, 6 obstacles": (TABLE_7[6],),
    "Table 7, 10 obstacles": (TABLE_7[10],),
    "Table 8": (TABLE_8,),
}
