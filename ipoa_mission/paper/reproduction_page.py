"""Fill the page of all tables and figures, `page.md`."""

from collections.abc import Mapping, Sequence
from importlib.resources import files

from ipoa_mission.paper.markdown import filled
from ipoa_mission.paper.markdown_table import Table
from ipoa_mission.paper.rows import Rows, runs_of


def page(made: Mapping[str, Table | str], sources: Mapping[str, Sequence[str]], rows: Rows) -> str:
    """Return the page in Markdown, for the folder of the figures and rows, with tables inline and figures linked.

    `sources` names the series of each table or figure.
    """
    shown = {name: _shown(name, item, sources[name]) for name, item in made.items()}
    words = files("ipoa_mission.paper").joinpath("page.md").read_text(encoding="utf-8")
    return filled(words.format_map({**shown, "measured": _measured(rows)}))


def _shown(name: str, item: Table | str, sources: Sequence[str]) -> str:
    shown = item.markdown() if isinstance(item, Table) else f"![{name}]({name}.svg)\n"
    linked = ", ".join(f"[`{one}.csv`](rows/{one}.csv)" for one in sources)
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
