"""Make the tables of docs/lab/link.md from rows."""

import statistics

from ipoa_mission.autopilot.autopilot import Autopilot
from tools.benchmarks.link_benchmark.measure import ITEMS
from tools.benchmarks.link_benchmark.rows import CLIENTS, Cell, Run


def told(runs: list[Run]) -> str:
    """Return a cell: exact of all (near ones, false ones), median seconds, items a second, bytes an item."""
    if not runs:
        return ""
    good = [one for one in runs if one.said and one.near]
    exact = sum(one.exact for one in good)
    lies = sum(one.said and not one.near for one in runs)
    words = f"{exact}/{len(runs)}"
    words += f" ({len(good) - exact} near)" if len(good) > exact else ""
    words += f" ({lies} false)" if lies else ""
    if not good:
        return words
    seconds = statistics.median(one.seconds for one in good)
    verified = [one.verified_s for one in good if one.verified_s is not None]
    both = f" ({statistics.median(verified):.2f})" if verified else ""
    size = statistics.median(one.bytes for one in good) / ITEMS
    return f"{words} · {seconds:.2f}{both} s · {ITEMS / seconds:.1f}/s · {size:.0f} B"


def table(rows: list[Run], autopilot: Autopilot) -> str:
    """Return the rows of one autopilot in Markdown: a line for each radio, a column for each client."""
    mine = [one for one in rows if one.autopilot == str(autopilot)]
    clients = [client for client in CLIENTS if any(one.client == client for one in mine)]
    lines = [f"| delay, ms | loss, % | {' | '.join(clients)} |", "|---" * (2 + len(clients)) + "|"]
    for delay_ms, loss in sorted({(one.delay_ms, one.loss_percent) for one in mine}):
        cells = [told([one for one in mine if one.cell == Cell(autopilot, delay_ms, loss, name)]) for name in clients]
        lines.append(f"| {delay_ms:g} | {loss:g} | {' | '.join(cells)} |")
    return "\n".join(lines)
