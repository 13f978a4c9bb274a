import csv
import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from ipoa_mission.paper.markdown import filled
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

    def csv(self) -> str:
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows([self.heading, *self.rows])
        return text.getvalue()


def _line(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def number(value: float) -> str:
    """Return five significant digits: 8676.7, 22.82, 0.00041, 1.2e-09."""
    if value == 0 or 1e-4 <= abs(value) < 1e7:
        digits = 2 if abs(value) >= 1 or value == 0 else 5
        return f"{value:,.{digits if abs(value) < 10000 else 0}f}"
    return f"{value:.1e}"


def ours_and_print(
    ours: Sequence[float], printed: Sequence[float], forms: Sequence[Callable[[float], str]]
) -> list[str]:
    """Return cells "ours (place) · printed (place)"."""
    columns = zip(ours, places(ours), printed, places(printed), strict=True)
    return [f"{forms[0](o)} ({p}) · {forms[1](t)} ({q})" for o, p, t, q in columns]


def per_cent(ours: float, theirs: float) -> str:
    return f"{(ours / theirs - 1) * 100:+.0f} %" if theirs else "-"


def factor(ours: float, theirs: float) -> str:
    return f"×{ours / theirs:.2g}" if theirs else "-"
