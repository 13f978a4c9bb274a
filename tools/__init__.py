"""Measure, generate, fuzz and fly the project: `python -m tools.FOLDER.NAME`, from its root."""

from argparse import ArgumentParser, RawDescriptionHelpFormatter
from pathlib import Path

REPOSITORY = Path(__file__).parents[1]


def command_line(docstring: str | None) -> ArgumentParser:
    """Return a parser with a tool's docstring as its help, and no option but `--help`."""
    return ArgumentParser(description=docstring, formatter_class=RawDescriptionHelpFormatter)
