"""Read the sources of a version of ArduCopter or PX4: which mission items it takes.

python -m tools.generate.firmware_tables FIRMWARE VERSION GIT REF           print the table of one version
python -m tools.generate.firmware_tables FIRMWARE VERSION GIT REF --write   put it into the package's tables

FIRMWARE is ardupilot or px4, VERSION like 4.7, GIT a git directory of the firmware, and REF a commit, tag or branch.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ipoa_mission.autopilot.autopilot import Autopilot, autopilot_named
from ipoa_mission.autopilot.commands import Command
from tools import command_line
from tools.generate import copter_source, px4_source
from tools.generate.sources import Source

READERS = {Autopilot.ARDUPILOT: copter_source.facts, Autopilot.PX4: px4_source.facts}


def table(autopilot: Autopilot, source: Source) -> dict[str, Any]:
    facts = READERS[autopilot](source)
    for part in ("placed", "plain", "nan", "used"):
        if part in facts:
            facts[part] = _by_row(facts[part])
    return {"ref": source.ref, **source.about(), **facts}


def _by_row(rows: Mapping[str, str]) -> dict[str, str]:
    named = sorted(rows, key=lambda name: int(name) if name.isdigit() else Command[name])
    return {row: " ".join(name for name in named if rows[name] == row) for row in sorted(set(rows.values()))}


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("firmware", type=autopilot_named)
    parser.add_argument("version")
    parser.add_argument("git", type=Path)
    parser.add_argument("ref")
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    facts = table(options.firmware, Source(options.git, options.ref))
    if not options.write:
        print(json.dumps(facts, indent=1))
        return
    path = options.firmware.tables.path
    tables = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    tables[options.version] = facts
    ordered = {name: tables[name] for name in sorted(tables, key=lambda v: [*map(int, v.split("."))])}
    path.write_text(json.dumps(ordered, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
