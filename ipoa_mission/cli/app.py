"""The `ipoa-mission` command: its verbs, and how a user's mistake is told.

Exit codes: 0 done; 1 not done (refused, collides, unreachable); 2 bad input. Every verb imports what it needs when it
runs, so that `--help` is quick.
"""

import sys

import typer

from ipoa_mission.cli import (
    checking,
    comparing,
    creating,
    flying,
    learning,
    linking,
    mocking,
    planning,
    reproducing,
    showing,
    studying,
    telling,
    verbosity,
)
from ipoa_mission.cli.groups import grouped
from ipoa_mission.cli.interrupting import Interrupted
from ipoa_mission.errors import MissionError

app = typer.Typer(
    name="ipoa-mission",
    rich_markup_mode="markdown",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.callback(no_args_is_help=True)(verbosity.before_the_verb)

#: The verbs as `--help` shows them.
VERBS = {
    "Begin here": (flying.demo,),
    "Plan and look": (
        creating.new,
        planning.plan,
        studying.studio,
        checking.check,
        checking.estimate,
        showing.show,
        showing.export,
    ),
    "Fly": (flying.fly, mocking.mock, comparing.compare, learning.learn),
    "The mission on a vehicle": (linking.scan, linking.upload, linking.download, linking.set_current, linking.clear),
    "A vehicle in flight": (linking.pause, linking.resume, linking.rtl),
    "More": (reproducing.reproduce, planning.schema),
}
for heading, verbs in VERBS.items():
    for verb in verbs:
        app.command(rich_help_panel=heading)(grouped(verb))


def main() -> None:
    """Run the command line; a mistake of the user is told in words, without a traceback."""
    telling.speak_anywhere()
    try:
        app(prog_name="ipoa-mission")
    except MissionError as error:
        telling.tell_error(error, as_json="--json" in sys.argv[1:])
        sys.exit(error.exit_code)
    except SystemExit as ended:
        if ended.code == Interrupted.exit_code:  # Typer ends so, without a word
            telling.tell_error(Interrupted("stopped: nothing was done"), as_json="--json" in sys.argv[1:])
        raise


if __name__ == "__main__":
    main()
