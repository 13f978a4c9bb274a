"""Provide the printed Tables 3 to 8 of Biomimetics 2024, 9, 647."""

import tomllib
from importlib.resources import files
from typing import Any

#: columns of all tables; the paper prints Tables 5 to 8 in another order
ALGORITHMS = ("ipoa", "dbo", "poa", "ssa", "mpoa", "hho")

RIVALS_OF_TABLE_4 = ("dbo", "poa", "ssa", "hho", "mpoa")

#: Numbers by table, part (function, experiment or map), and measure. `table_4` has p against `RIVALS_OF_TABLE_4`.
PRINTED: dict[str, Any] = tomllib.loads(
    files("ipoa_mission.paper").joinpath("published.toml").read_text(encoding="utf-8")
)


def improved(where: str) -> list[dict[str, list[float]]]:
    """Return the printed parts that a claim in the text is about: "Table 6" or "Table 7, 10 obstacles"."""
    name, _, obstacles = where.removesuffix(" obstacles").partition(", ")
    table = PRINTED[name.lower().replace(" ", "_")]
    return [table[obstacles]] if obstacles else [table] if name == "Table 8" else list(table.values())
