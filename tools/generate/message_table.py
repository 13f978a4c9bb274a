"""The table of MAVLink's messages that a wheel carries: `python -m tools.generate.message_table FOLDER`."""

import json
import sys
from pathlib import Path

from ipoa_mission.link.definitions import TABLE, rows


def main() -> None:
    (Path(sys.argv[1]) / TABLE).write_text(json.dumps(rows(), separators=(",", ":")), encoding="utf-8")


if __name__ == "__main__":
    main()
