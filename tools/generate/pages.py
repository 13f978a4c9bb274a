"""Print tables, or with `--write` put them between the markers of a page."""

from argparse import ArgumentParser
from pathlib import Path

from ipoa_mission.paper.markdown_table import filled
from tools import command_line

BEGIN, END = "<!-- table: begin -->", "<!-- table: end -->"


def table_command(docstring: str | None) -> ArgumentParser:
    parser = command_line(docstring)
    parser.add_argument("--write", action="store_true", help="put it into the page")
    return parser


def print_or_write(text: str, page: Path, is_written: bool) -> None:
    if not is_written:
        print(text)
        return
    before, rest = page.read_text(encoding="utf-8").split(BEGIN)
    page.write_text(f"{before}{BEGIN}\n{filled(text)}{END}{rest.split(END)[1]}", encoding="utf-8")
