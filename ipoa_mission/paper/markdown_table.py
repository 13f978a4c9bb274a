import re
import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from ipoa_mission.paper.statistics import places


@dataclass(frozen=True)
class Table:
    caption: str
    heading: Sequence[str]
    rows: Sequence[Sequence[str]]
    notes: Sequence[str] = field(default=())

    def markdown(self) -> str:
        lines = [f"**{self.caption}**", "", _line(self.heading), _line(["---"] * len(self.heading))]
        lines += [_line(row) for row in self.rows]
        for note in self.notes:
            lines += ["", note]
        return filled("\n".join(lines))


def _line(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def number(value: float) -> str:
    """Return five significant digits: 8676.7, 22.82, 0.00041, 1.2e-09."""
    if value == 0 or 1e-4 <= abs(value) < 1e7:
        digits = 2 if abs(value) >= 1 or value == 0 else 5
        return f"{value:,.{digits if abs(value) < 10000 else 0}f}"
    return f"{value:.1e}"


def ours_and_print(
    ours: Sequence[float],
    printed: Sequence[float],
    form: Callable[[float], str] = number,
    printed_form: Callable[[float], str] = number,
) -> list[str]:
    columns = zip(ours, places(ours), printed, places(printed), strict=True)
    return [f"{form(o)} ({p}) · {printed_form(t)} ({q})" for o, p, t, q in columns]


def per_cent(ours: float, theirs: float) -> str:
    return f"{(ours / theirs - 1) * 100:+.0f} %" if theirs else "-"


def factor(ours: float, theirs: float) -> str:
    return f"×{ours / theirs:.2g}" if theirs else "-"


def filled(text: str) -> str:
    r"""Fill paragraphs and list items to 120 columns.

    >>> print(filled("* one\n  and\n* two"), end="")
    * one and
    * two
    """
    return "\n\n".join(_filled(block) for block in re.split(r"\n\n+", text.strip("\n"))) + "\n"


def _filled(block: str) -> str:
    if block.startswith(("|", "#", "!")):  # tables, headings, pictures
        return block
    if block.startswith("* "):
        return "\n".join(f"* {_paragraph(item, '  ')}" for item in re.split(r"(?m)^\* ", block)[1:])
    return _paragraph(block, "")


def _paragraph(words: str, indent: str) -> str:
    # a sign of a list or heading must not begin a line
    glue = "\N{NO-BREAK SPACE}"
    glued = re.sub(r" (?=([-+*=#>]|\d+[.)]) )", glue, words.replace("\n", " "))
    lines = textwrap.wrap(re.sub(" +", " ", glued), 120 - len(indent), break_long_words=False, break_on_hyphens=False)
    return f"\n{indent}".join(lines).replace(glue, " ")
