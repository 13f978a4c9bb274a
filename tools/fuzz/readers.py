"""Feed damaged missions, maps and logs to the readers, and use what they accept.

    python -m tools.fuzz.readers --seconds 600 --seed 1

Every file must be read, or refused with a `BadInput` that begins with its name. A mission that was read is checked,
shown, exported, written, read again and put on the wire without any error but `MissionError`. Maps become obstacles and
zones, logs flights. A file may take 5 s of CPU. The first failure is kept and its traceback shown.
"""

import json
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np

from ipoa_mission.checks.check import check_mission
from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.mission.items import Mission
from ipoa_mission.mission.mission_io import read_mission, write_mission
from ipoa_mission.mission.stored_mission import as_stored, compare, from_wire, to_wire
from ipoa_mission.report.exports import EXPORTS, write_export
from tools import REPOSITORY, command_line
from tools.fuzz.foreign_sources import probe_foreign
from tools.fuzz.foreign_sources import sources as sources_of_others

LONGEST = 5.0  # CPU limit of a file [s]
TESTS = REPOSITORY / "tests"
GOOD = sorted((TESTS / "mission" / "files").iterdir())
BAD = sorted((TESTS / "broken").glob("*.[pw]*"))
NASTY: list[Any] = [
    None, True, False, 0, -1, 1, 16, 177, 0.5, 1e308, -1e308, 10**400, 65536, 2**63, "", "NaN", "16", "\x00", "é" * 50,
    [], [1, 2], [[]], {}, {"a": 1}, [None] * 7, [1e200] * 7, 90.0000001, 180, 83000, -0.0, 5e-324,
]  # fmt: skip
PLAUSIBLE: list[Any] = [
    0, 1, 2, 3, 5, 6, 10, 11, 16, 17, 18, 19, 20, 21, 22, 31, 82, 93, 177, 178, 206, 600, 5001, 5003, 5100, -1,
    None, 90, -90, 180, 200, 2.5, 45.5, -500, 70000, 1e6, "SimpleItem", "ComplexItem", [39.1, 121.8], [39.1, 121.8, 5],
]  # fmt: skip
TOKENS = [
    b"NaN", b"Infinity", b"-", b"1e999", b"1e-999", b"null", b"\t", b"\r", b"\n", b"\r\n", b'"', b"\\u0000", b"\xff",
    b"\xef\xbb\xbf", b"[" * 2000, b"{", b"}", b"]", b",", b":", b"9" * 5000, b"#", b"QGC WPL 110\n", b"\xe2\x80\xa8",
    b"nan", b"inf", b"0x10", b"1_0", b" ", b"\x0c",
]  # fmt: skip


def spoil_bytes(data: bytes, rng: np.random.Generator) -> bytes:
    """Return the bytes with one to four places cut, doubled, overwritten or filled with special bytes."""
    for _ in range(rng.integers(1, 5)):
        a, b = sorted(int(n) for n in rng.integers(0, len(data) + 1, 2))
        b = min(b, a + int(rng.integers(1, 80)))
        token = TOKENS[rng.integers(len(TOKENS))]
        data = [
            data[:a] + data[b:],
            data[:b] + data[a:],
            data[:a] + token + data[b:],
            data[:a] + token + data[a:],
            data[:a] + rng.bytes(3) + data[a + 3 :],
            data[:a],
        ][rng.integers(6)]
    return data


def spoil_json(data: bytes, rng: np.random.Generator) -> bytes:
    """Return the document with one to three values replaced, removed or doubled."""
    try:
        document = json.loads(data)
    except (ValueError, RecursionError):
        return spoil_bytes(data, rng)
    for _ in range(rng.integers(1, 3)):
        places = list(_places(document))
        if places:
            parent, key = places[rng.integers(len(places))]
            match int(rng.integers(4)):
                case 0:
                    del parent[key]
                case 1 if isinstance(parent, list):
                    parent.insert(int(rng.integers(len(parent) + 1)), deepcopy(parent[key]))
                case _:
                    parent[key] = _value(rng)
    return json.dumps(document).encode()


def spoil_fields(data: bytes, rng: np.random.Generator) -> bytes:
    """Return the lines with one to three fields replaced."""
    lines = [line.split(b"\t") for line in data.split(b"\n")]
    for _ in range(rng.integers(1, 3)):
        line = lines[rng.integers(len(lines))]
        token = rng.random() < 0.1
        line[rng.integers(len(line))] = TOKENS[rng.integers(len(TOKENS))] if token else str(_value(rng)).encode()
    return b"\n".join(b"\t".join(line) for line in lines)


def _value(rng: np.random.Generator) -> Any:
    values = NASTY if rng.random() < 0.3 else PLAUSIBLE
    return deepcopy(values[rng.integers(len(values))])


def _places(node: Any) -> Any:
    """Yield (parent, key) of every value."""
    pairs = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, value in list(pairs):
        yield node, key
        yield from _places(value)


SPOIL: list[Callable[[bytes, np.random.Generator], bytes]] = [spoil_bytes, spoil_json, spoil_fields]


def probe(path: Path) -> str:
    """Read one file: `refused` or `read`. Raises AssertionError, or the reader's fault."""
    try:
        mission = read_mission(path)
    except BadInput as error:
        if not str(error).startswith(f"{path}: "):
            raise AssertionError(f"does not begin with the file: {error}") from error
        return "refused"
    use(mission, path.parent)
    return "read"


def use(mission: Mission, folder: Path) -> None:
    """Use a mission in every way."""
    check_mission(mission)
    wire = to_wire(mission)
    stored = as_stored(wire, mission.autopilot)
    assert compare(wire, stored, mission.autopilot) is None
    from_wire(stored, mission.autopilot, mission.home)
    for suffix in EXPORTS:
        _done(write_export, mission, folder / f"again{suffix}")
    for suffix in (".plan", ".waypoints"):
        path = folder / f"again{suffix}"
        if _done(write_mission, mission, path):
            assert len(read_mission(path, mission.autopilot).items) == len(mission.items)


def _done(write: Callable[[Mission, Path], object], mission: Mission, path: Path) -> bool:
    """Return whether the mission was written; a refusal with a message is valid."""
    try:
        write(mission, path)
    except MissionError:
        return False
    return True


def fuzz(seconds: float, seed: int, folder: Path) -> Counter[str]:
    """Probe damaged files for `seconds`; count the outcomes."""
    rng = np.random.default_rng(seed)
    sources = [(path.suffix, path.read_bytes()) for path in (*GOOD * (4 * len(BAD) // len(GOOD)), *BAD)]
    foreign = sources_of_others()
    seen: Counter[str] = Counter()
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        given = sources if rng.random() < 0.5 else foreign
        suffix, data = given[rng.integers(len(given))]
        path = folder / f"fuzz{suffix}"
        path.write_bytes(SPOIL[rng.integers(len(SPOIL))](data, rng))
        began = time.process_time()
        is_mission = suffix in (".plan", ".waypoints")
        seen[f"{'mission' if is_mission else suffix} {(probe if is_mission else probe_foreign)(path)}"] += 1
        if (took := time.process_time() - began) > LONGEST:
            raise AssertionError(f"took {took:.1f} s")
    return seen


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="fuzz-") as folder:
        try:
            print(dict(fuzz(given.seconds, given.seed, Path(folder))))
        except Exception:
            traceback.print_exc()
            for path in Path(folder).glob("fuzz*"):
                kept = Path(path.name)
                kept.write_bytes(path.read_bytes())
                print(f"kept as {kept}", file=sys.stderr)
            sys.exit(1)


if __name__ == "__main__":
    main()
