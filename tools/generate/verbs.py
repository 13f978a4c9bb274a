"""Write docs/verbs.md: every verb with its arguments and options, and the verbs of each option.

python -m tools.generate.verbs
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from inspect import Parameter, signature
from typing import Any, get_args

from typer.models import OptionInfo

from ipoa_mission.cli.app import VERBS
from ipoa_mission.cli.planners import grouped
from tools import REPOSITORY, command_line

PAGE = REPOSITORY / "docs" / "verbs.md"
HEAD = """\
# Verbs and flags

Made from the code by `python -m tools.generate.verbs`; a test holds it against what the command line takes.
`ipoa-mission VERB --help` prints a verb's part of it.
"""
FLAGS = """\
## Flags

A flag means the same in every verb that takes it; the few that are listed twice differ.

| flag | value | meaning | left out | verbs |
|---|---|---|---|---|
"""


@dataclass(frozen=True)
class Flag:
    name: str
    value: str
    default: str
    words: str
    is_option: bool


def flags(verb: Callable[..., None]) -> tuple[Flag, ...]:
    parameters = signature(grouped(verb)).parameters.values()
    shown = [one for one in parameters if not getattr(get_args(one.annotation)[1], "hidden", False)]
    return tuple(_flag(parameter.annotation, parameter.default) for parameter in shown)


def _flag(hint: Any, default: Any) -> Flag:
    kind, info = get_args(hint)
    is_option = isinstance(info, OptionInfo)
    name = ", ".join((info.default, *info.param_decls)) if is_option else str(info.metavar)
    choices = [choice for part in (get_args(kind) or (kind,)) if isinstance(part, type) for choice in _choices(part)]
    value = " or ".join(choices) or (str(info.metavar or "") if is_option else "")
    return Flag(name, value, _shown(default), str(info.help), is_option)


def _choices(kind: type) -> list[str]:
    return [str(member) for member in kind] if issubclass(kind, StrEnum) else []


def _shown(default: Any) -> str:
    if default is Parameter.empty:
        return "needed"
    if default is None or default is False:
        return ""
    return "yes" if default is True else " ".join(map(str, default)) if isinstance(default, tuple) else str(default)


def rows() -> dict[Flag, list[str]]:
    takers: dict[Flag, list[str]] = {}
    for name, verb in by_name().items():
        for flag in flags(verb):
            if flag.is_option:
                takers.setdefault(flag, []).append(name)
    return dict(sorted(takers.items(), key=lambda row: row[0].name))


def by_name() -> dict[str, Callable[..., None]]:
    return {verb.__name__.replace("_", "-"): verb for verbs in VERBS.values() for verb in verbs}


def page() -> str:
    parts = [HEAD]
    names = {verb: name for name, verb in by_name().items()}
    for heading, verbs in VERBS.items():
        parts.append(f"## {heading}\n")
        for verb in verbs:
            arguments = [flag for flag in flags(verb) if not flag.is_option]
            parts += [f"### {names[verb]}\n", _about(grouped(verb).__doc__ or "")]
            parts += ["".join(f"* `{flag.name}`: {flag.words}\n" for flag in arguments)] if arguments else []
    cells = (
        f"| `{flag.name}` | {flag.value} | {flag.words} | {flag.default} | {', '.join(takers)} |"
        for flag, takers in rows().items()
    )
    return "\n".join(parts) + "\n" + FLAGS + "\n".join(cells) + "\n"


def _about(docstring: str) -> str:
    lines = [line.removeprefix("    ") for line in docstring.strip().splitlines()]
    words = "\n".join(line for line in lines if not line.startswith("Example: "))
    examples = [line.removeprefix("Example: ").strip("`") for line in lines if line.startswith("Example: ")]
    return words.strip() + "\n" + "".join(f"\n```sh\n{example}\n```\n" for example in examples)


if __name__ == "__main__":
    command_line(__doc__).parse_args()
    PAGE.write_text(page(), encoding="utf-8")
