"""The `ipoa-mission` command: its verbs, and how a user's mistake is told.

Exit codes: 0 done; 1 not done (refused, collides, unreachable); 2 bad input. Every verb imports what it needs when it
runs, so that `--help` is quick.
"""

import sys

import typer

from ipoa_mission.cli import checking, comparing, creating, flying, linking, planning, reproducing, showing, telling
from ipoa_mission.errors import MissionError

app = typer.Typer(
    name="ipoa-mission",
    help="Plan an obstacle-free flight, write it as a QGroundControl mission, upload it, know how long it will fly.",
    no_args_is_help=True,
    rich_markup_mode="markdown",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
for verb in (
    creating.new,
    planning.plan,
    checking.check,
    checking.estimate,
    showing.show,
    showing.export,
    linking.scan,
    linking.upload,
    linking.download,
    linking.clear,
    flying.fly,
    flying.mock,
    comparing.compare,
    reproducing.reproduce,
    planning.schema,
):
    app.command()(verb)


def main() -> None:
    """Run the command line; a mistake of the user is told in words, without a traceback."""
    try:
        app()
    except MissionError as error:
        telling.tell_error(error)
        sys.exit(error.exit_code)


if __name__ == "__main__":
    main()
