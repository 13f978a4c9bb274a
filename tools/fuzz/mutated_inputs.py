"""Test that no change of a mission, log, terrain or parameter file is lost without a message.

`python -m tools.fuzz.mutated_inputs --count 10000` tries 10000 changes; exit code 1 after a silent loss.
"""

import argparse
import random
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

from tools.fuzz import mutated_logs as logs
from tools.fuzz import mutated_missions as missions
from tools.fuzz import mutated_terrain as terrain
from tools.fuzz.outcome import Outcome, Reading, judge

Change = Callable[[random.Random, Path], tuple[str, str | bytes, str | bytes]]
#: By suffix: change, reader, and relative frequency.
KINDS: dict[str, tuple[Change, Callable[[Path], Reading], int]] = {
    ".plan": (missions.changed_plan, missions.read_mission_text, 4),
    ".waypoints": (missions.changed_list, missions.read_mission_text, 2),
    ".params": (missions.changed_parameters, missions.read_parameter_text, 2),
    ".tif": (terrain.changed_tiff, terrain.read_model, 2),
    ".asc": (terrain.changed_grid, terrain.read_model, 1),
    ".hgt": (terrain.changed_tile, terrain.read_model, 1),
    ".tlog": (partial(logs.changed, ".tlog"), logs.read_log, 3),
    ".bin": (partial(logs.changed, ".bin"), logs.read_log, 3),
    ".ulg": (partial(logs.changed, ".ulg"), logs.read_log, 2),
}


def tries(count: int, seed: int, kinds: tuple[str, ...] = ()) -> Iterator[tuple[str, str, Outcome, str]]:
    """Yield reader, change, outcome and changed file, `count` times."""
    chance = random.Random(seed)
    suffixes = [suffix for suffix, (*_, often) in KINDS.items() for _ in range(often) if not kinds or suffix in kinds]
    with tempfile.TemporaryDirectory() as folder:
        for n in range(count):
            suffix = chance.choice(suffixes)
            change, read, _ = KINDS[suffix]
            name, before, after = change(chance, Path(folder))
            path = Path(folder) / f"{n}{suffix}"
            outcome = judge(path, before, after, read)
            shown = after if isinstance(after, str) else f"{len(after)} bytes, change {n} of seed {seed}"
            yield suffix, name, outcome, shown
            path.unlink(missing_ok=True)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--of", nargs="*", default=[], choices=[*KINDS], help="readers; left out, all")
    options = parser.parse_args()
    counts = Counter[tuple[str, Outcome]]()
    for suffix, name, outcome, shown in tries(options.count, options.seed, tuple(options.of)):
        counts[suffix, outcome] += 1
        if outcome == "lost":
            print(f"lost without a word: {suffix}: {name}: {shown}")
    outcomes: tuple[Outcome, ...] = ("named", "same", "more cautious", "lost")
    print(f"| reader | changes | {' | '.join(outcomes)} |")
    for suffix in KINDS:
        row = [counts[suffix, outcome] for outcome in outcomes]
        print(f"| `{suffix}` | {sum(row):,} | {' | '.join(f'{number:,}' for number in row)} |")
    return 1 if any(count for (_, outcome), count in counts.items() if outcome == "lost") else 0


if __name__ == "__main__":
    raise SystemExit(main())
