"""What the project is measured, generated, fuzzed and flown with: `python -m tools.FOLDER.NAME`, from its root."""

from argparse import ArgumentParser, RawDescriptionHelpFormatter
from pathlib import Path

REPOSITORY = Path(__file__).parents[1]


def command_line(told: str | None) -> ArgumentParser:
    """A parser that tells of a tool as its docstring does, and takes nothing but `--help` until more is added."""
    return ArgumentParser(description=told, formatter_class=RawDescriptionHelpFormatter)
