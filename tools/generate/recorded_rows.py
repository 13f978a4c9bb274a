"""Put the tables of recorded flights into CSV files, and their summaries into a page of the docs."""

import csv
import io
from pathlib import Path

from ipoa_mission.files import write_atomically
from ipoa_mission.paper.markdown_table import filled
from tools import REPOSITORY

BEGIN, END = "<!-- table: begin -->", "<!-- table: end -->"


def put(text: str, page: Path, files: tuple[str, ...]) -> None:
    """Write each table, by its header, to the next of `files` in docs/data, and the rest between the page's markers."""
    kinds: dict[str, list[list[str]]] = {}
    lines: list[str] = []
    heading = header = ""
    for line in text.splitlines():
        row = [cell.strip() for cell in line.strip("|").split("|")]
        if not line.startswith("|"):
            lines.append(line)
            heading = line.removeprefix("### ") if line.startswith("###") else heading
        elif line.startswith("| flight |"):
            header = line
            kinds.setdefault(header, [["group", *row]])
        elif not line.startswith("|--"):
            kinds[header].append([heading, *row])
    for name, rows in zip(files, kinds.values(), strict=True):
        out = io.StringIO()
        csv.writer(out, lineterminator="\n").writerows(rows)
        write_atomically(REPOSITORY / "docs" / "data" / name, out.getvalue())
    before, rest = page.read_text(encoding="utf-8").split(BEGIN)
    summary = filled("\n".join(lines))
    write_atomically(page, f"{before}{BEGIN}\n{summary}{END}{rest.split(END)[1]}")
