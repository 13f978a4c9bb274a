"""Define options before the verb."""

import logging
from typing import Annotated

import typer

from ipoa_mission.cli.output import print_lines, shown

LEVELS = (logging.WARNING, logging.INFO, logging.DEBUG)


def print_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        print_lines(f"ipoa-mission {version('ipoa-mission')}")
        raise typer.Exit


VerboseOption = Annotated[
    int,
    typer.Option(
        "--verbose",
        "-v",
        count=True,
        metavar="",
        show_default=False,
        help="Log events; twice: all details.",
    ),
]
VersionOption = Annotated[
    bool,
    typer.Option("--version", metavar="", is_eager=True, callback=print_version, help="Print the version and end."),
]


def before_the_verb(verbose: VerboseOption = 0, version: VersionOption = False) -> None:
    """Plan an obstacle-free flight, write it as a QGroundControl mission, upload it, and forecast its time.

    Exit codes: 0 done, 1 not done (refused, collides, unreachable), 2 bad input, 130 stopped by Ctrl-C.

    Example: `ipoa-mission fly missions/campus.toml --out out --report`
    """
    listen_to_log(LEVELS[min(verbose, len(LEVELS) - 1)])


def listen_to_log(level: int) -> None:
    handler = logging.StreamHandler()
    detailed = "%(relativeCreated)6d ms  %(levelname)-7s %(name)s: %(message)s"
    handler.setFormatter(_Plain() if level == logging.WARNING else _Detailed(detailed))
    ours = logging.getLogger("ipoa_mission")
    ours.handlers[:] = [handler]
    ours.setLevel(level)


class _Plain(logging.Formatter):
    def format(self, record: logging.LogRecord) -> str:
        return shown(f"{record.levelname.lower()}: {record.getMessage()}")


class _Detailed(logging.Formatter):
    def format(self, record: logging.LogRecord) -> str:
        return shown(super().format(record))
