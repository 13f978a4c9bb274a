"""The page of findings: `findings.md`, its places filled with facts, tables and figures."""

import re
from collections.abc import Mapping, Sequence
from importlib.resources import files

from ipoa_mission.experiments.facts import facts, signs
from ipoa_mission.experiments.markdown import filled
from ipoa_mission.experiments.rows import Rows, runs_of
from ipoa_mission.experiments.tables import Table

NOT_SO = "*(Not so in these rows:)* "


def findings(made: Mapping[str, Table | str], sources: Mapping[str, Sequence[str]], rows: Rows, folder: str) -> str:
    """The page, in Markdown; tables are set in it, figures are linked from `folder` beside it.

    `sources` names the series that each table or figure is made of. A sentence whose sign does not hold, as may be
    with few runs, says so.
    """
    values = facts(rows)
    holds = signs(values)
    shown = {name: _shown(name, item, sources[name], folder) for name, item in made.items()}
    words = re.sub(r"(?m)^\* \[(\w+)\] ", lambda m: "* " if holds[m[1]] else f"* {NOT_SO}", template())
    return filled(words.format_map({**values, **shown, "folder": folder, "measured": _measured(rows)}))


def template() -> str:
    """The page with places to fill, in Markdown."""
    return files("ipoa_mission.experiments").joinpath("findings.md").read_text(encoding="utf-8")


def _shown(name: str, item: Table | str, sources: Sequence[str], folder: str) -> str:
    shown = item.markdown() if isinstance(item, Table) else f"![{name}]({folder}/{name}.svg)\n"
    linked = ", ".join(f"[`{one}.csv`]({folder}/rows/{one}.csv)" for one in sources)
    return f"{shown}\n*`ipoa-mission reproduce {name}`; {f'rows: {linked}' if linked else 'needs no runs'}.*"


def _measured(rows: Rows) -> str:
    lines = ["| series | runs | rows | measured | versions | CPU |", "| --- | --- | --- | --- | --- | --- |"]
    for name, series in rows.items():
        dates = sorted({row.date for row in series})
        versions = "; ".join(sorted({row.versions for row in series}))
        minutes = sum(row.seconds for row in series) / 60
        when = dates[0] if len(dates) == 1 else f"{dates[0]} to {dates[-1]}"
        lines.append(f"| {name} | {runs_of(series)} | {len(series)} | {when} | {versions} | {minutes:.1f} min |")
    return "\n".join(lines)
