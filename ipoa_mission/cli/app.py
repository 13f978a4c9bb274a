import errno
import logging
import os
import re
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from copy import copy
from functools import cache, partial
from importlib import import_module
from itertools import cycle
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple, get_args, get_origin

import typer

from ipoa_mission.cli.checking import check, estimate
from ipoa_mission.cli.comparing import compare
from ipoa_mission.cli.flying import demo, fly
from ipoa_mission.cli.interrupting import ChangesMade, interruptible
from ipoa_mission.cli.linking import clear, download, pause, resume, rtl, scan, upload
from ipoa_mission.cli.mocking import mock
from ipoa_mission.cli.planners import grouped
from ipoa_mission.cli.planning import new, plan, schema
from ipoa_mission.cli.showing import export, show
from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.files import plug_ins
from ipoa_mission.interrupts import noted_terminations
from ipoa_mission.terminal import discard_output, print_error, print_lines, replace_unencodable, shown

if TYPE_CHECKING:
    from rich.text import Text


def print_version(wanted: bool) -> None:
    if wanted:
        print_lines(f"ipoa-mission {import_module('importlib.metadata').version('ipoa-mission')}")
        raise typer.Exit


VerboseOption = Annotated[
    int, typer.Option("--verbose", "-v", count=True, show_default=False, help="Log events; twice: all details.")
]
VersionOption = Annotated[
    bool, typer.Option("--version", is_eager=True, callback=print_version, help="Print the version and end.")
]


def before_the_verb(verbose: VerboseOption = 0, version: VersionOption = False) -> None:
    """Plan an obstacle-free flight, write it as a QGroundControl mission, upload it, and forecast its time.

    Exit codes: 0 done, 1 not done (refused, collides, unreachable), 2 bad input, 130 stopped by Ctrl-C.

    Example: `ipoa-mission fly missions/campus.toml --out out --report`
    """
    levels = (logging.WARNING, logging.INFO, logging.DEBUG)
    listen_to_log(levels[min(verbose, 2)])


def listen_to_log(level: int) -> None:
    handler = logging.StreamHandler()
    detailed = "%(relativeCreated)6d ms  %(levelname)-7s %(name)s: %(message)s"
    handler.setFormatter(_Printable("%(levelname)s: %(message)s" if level == logging.WARNING else detailed))
    ours = logging.getLogger("ipoa_mission")
    ours.handlers[:] = [handler]
    ours.setLevel(level)


class _Printable(logging.Formatter):
    def format(self, record: logging.LogRecord) -> str:
        record.levelname = record.levelname.lower()
        return shown(super().format(record))


app = typer.Typer(
    name="ipoa-mission",
    rich_markup_mode="markdown",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.callback(no_args_is_help=True)(before_the_verb)

HEADINGS: dict[str, tuple[str | Callable[..., None], ...]] = {
    "Begin here": (demo,),
    "Plan and look": (new, plan, "studio", check, estimate, show, export, "deconflict"),
    "Fly": (fly, mock, compare, "learn"),
    "The mission on a vehicle": (scan, upload, download, clear),
    "A vehicle in flight": (pause, resume, rtl),
    "More": ("reproduce", schema),
}


def _verbs() -> dict[str, tuple[Callable[..., None], ...]]:
    plugged_in = {entry.name: entry for entry in plug_ins("verbs")}
    verbs = {
        heading: tuple(
            plugged_in.pop(verb).load() if isinstance(verb, str) else verb
            for verb in listed
            if not isinstance(verb, str) or verb in plugged_in
        )
        for heading, listed in HEADINGS.items()
    }
    return verbs | {"More": (*verbs["More"], *(plugged_in[name].load() for name in sorted(plugged_in)))}


VERBS = _verbs()
for heading, verbs in VERBS.items():
    for verb in verbs:
        app.command(verb.__name__.replace("_", "-"), rich_help_panel=heading)(grouped(verb))


def spare_imports(verb: Any, options: Iterable[Any]) -> None:
    """Spare Typer's slow imports: pydantic for options, and Rich's Markdown for help."""
    verb.format_help = partial(format_help, verb.format_help)
    for option in options:
        if hasattr(option, "get_runtime_param"):  # since Typer 0.29
            conversion = partial(convert, option.get_runtime_param)
            option.get_runtime_param = partial(SimpleNamespace, coerce=conversion)


class Prose(NamedTuple):
    """Paragraphs with code in backticks, drawn as by Rich's Markdown."""

    text: str
    style: str = ""

    def __rich_console__(self, *_console: object) -> "Iterator[Text]":
        from rich.text import Text

        parts = re.sub(r"(?<!\n)\n(?!\n)", " ", self.text).split("`")
        yield Text.assemble(*zip(parts, cycle(("", "markdown.code")), strict=False), style=self.style)


def format_help(by_typer: Callable[..., None], *context: object) -> None:
    """Draw help by Typer, with `Prose` in place of Rich's modules."""
    spared = {"rich.markdown", "rich.traceback"} - sys.modules.keys()
    sys.modules.update(dict.fromkeys(spared, SimpleNamespace(Markdown=Prose, Traceback=Prose)))  # type: ignore[arg-type]
    import_module("typer.rich_utils")
    for name in spared:
        del sys.modules[name]
    by_typer(*context)


def convert(by_typer: Callable[[], Any], value: Any, param: Any, ctx: object) -> Any:
    kind = param.type_descriptor.annotation
    is_list = get_origin(kind) is list
    if value is None:
        return () if param.multiple or param.nargs == -1 else None
    element = get_args(kind)[0] if is_list else kind
    values = value if is_list else [value]
    if param.type_descriptor.parameter_info.parser or not all(_is_plain(element, one) for one in values):
        return by_typer().coerce(value, param=param, ctx=ctx)
    plain = [Path(one) if element is Path else one for one in values]
    return plain if is_list else plain[0]


def _is_plain(kind: Any, value: Any) -> bool:
    if kind is Path:
        return os.access(value, os.R_OK) or not os.path.exists(value)  # noqa: PTH110
    return isinstance(kind, type) and isinstance(value, kind)


@cache
def command(name: str = "") -> Any:
    """Return the command line, with this verb alone if there is one; flags show no value in the help."""
    only = copy(app)
    only.registered_commands = [verb for verb in app.registered_commands if verb.name == name]
    line = typer.main.get_command(only if only.registered_commands else app)
    for verb in (line, *line.commands.values()):  # type: ignore[attr-defined]
        helps = verb.get_help_option(typer.Context(verb))
        options = [*verb.params, *([] if helps is None else [helps])]
        spare_imports(verb, options)
        for option in options:
            if getattr(option, "is_flag", False) and option.metavar is None:
                option.metavar = ""
    return line


UsageError: Any = typer.BadParameter.__base__  # of Click, or of Typer's copy of it


def run_line(_: ChangesMade) -> None:
    """Exit as Typer does, but raise BadInput for options that it does not take."""
    try:
        sys.exit(command(*sys.argv[1:2])(prog_name="ipoa-mission", standalone_mode=False))
    except UsageError as error:
        words = error.format_message()
        if not words:  # the help, which is printed
            sys.exit(error.exit_code)
        raise BadInput(words, hint=f"{error.ctx.command_path} --help", code="usage") from None


def main() -> None:
    replace_unencodable()
    try:
        with noted_terminations():
            interruptible(run_line)()
    except MissionError as error:
        with suppress(KeyboardInterrupt):
            print_error(error, as_json="--json" in sys.argv[1:])
        sys.exit(error.exit_code)
    except OSError as error:
        if error.errno != errno.ENOSPC:
            raise
        discard_output()
        print_error(MissionError(f"the output is incomplete: {error.strerror}", code="unwritable"))
        sys.exit(MissionError.exit_code)
