"""Spare Typer's slow imports: pydantic for options, and Rich's Markdown for help."""

import os
import re
import sys
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from importlib import import_module
from itertools import cycle
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, NamedTuple, get_args, get_origin

if TYPE_CHECKING:
    from rich.text import Text


def spare_imports(verb: Any, options: Iterable[Any]) -> None:
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
    """Return the value as Typer converts it."""
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
