"""Ask a real autopilot, by pymavlink, for its verdict on every generated item, and record it.

python -m tools.verdicts LINK FIRMWARE TABLE COMMIT FILE

LINK is as pymavlink has it (tcp:127.0.0.1:5760, udpin:127.0.0.1:14550), FIRMWARE ardupilot or px4, TABLE the version
whose table is to agree, COMMIT of the source that runs there, FILE the record to write.
"""

import json
import math
import time
from pathlib import Path
from typing import Any

from pymavlink import mavutil

from ipoa_mission.link.wire import INT32_MAX
from ipoa_mission.mission.items import Item
from ipoa_mission.vehicles.autopilot import Autopilot, autopilot_named
from ipoa_mission.vehicles.version import Version
from tests.verdicts import COMMANDS, FRAMES, LETTERS, UNASKED, UNKNOWN, item, row
from tools import command_line

PATIENCE_S = 1.0
TRIES = 8


class Asked:
    """An autopilot at the other end of a pymavlink connection."""

    def __init__(self, link: str, autopilot: Autopilot) -> None:
        self.line: Any = mavutil.mavlink_connection(link, source_system=255, dialect="ardupilotmega")
        self.line.wait_heartbeat(timeout=60)
        self.home = [item(16, 0, 0, 0.0)] if autopilot is Autopilot.ARDUPILOT else []

    def says(self) -> str:
        """The version that it says of itself."""
        self.line.mav.command_long_send(self.line.target_system, 1, 512, 0, 148, 0, 0, 0, 0, 0, 0)
        heard = self.line.recv_match(type="AUTOPILOT_VERSION", blocking=True, timeout=5)
        return str(Version.said(heard.flight_sw_version)) if heard else ""

    def letter(self, one: Item) -> str:
        """The verdict as a record has it."""
        if one.command in UNASKED and math.isnan(one.altitude) and self.home:
            return UNKNOWN
        return LETTERS[self.verdict(one)]

    def verdict(self, one: Item) -> int:
        """The result that ends the upload of a list with this item."""
        items = [*self.home, one]
        for _ in range(TRIES):
            while self.line.recv_match(blocking=False) is not None:
                pass
            self.line.mav.mission_count_send(self.line.target_system, 1, len(items), 0)
            until = time.monotonic() + PATIENCE_S
            while time.monotonic() < until:
                heard = self.line.recv_match(
                    type=["MISSION_REQUEST", "MISSION_REQUEST_INT", "MISSION_ACK"], blocking=True, timeout=0.2
                )
                if heard is None or heard.mission_type != 0:
                    continue
                if heard.get_type() == "MISSION_ACK":
                    return int(heard.type)
                self._send(heard.seq, items[heard.seq])
            self.line.mav.mission_ack_send(self.line.target_system, 1, 15, 0)  # cancelled, and once more
            time.sleep(0.2)
        raise SystemExit(f"{one}: no verdict")

    def _send(self, seq: int, one: Item) -> None:
        placed = one.frame != 2
        x, y = (
            INT32_MAX if math.isnan(value) else round(value * (1e7 if placed else 1))
            for value in (one.latitude_deg, one.longitude_deg)
        )
        about = (seq, int(one.frame), int(one.command), 0, 1)
        self.line.mav.mission_item_int_send(self.line.target_system, 1, *about, *one.params, x, y, one.altitude, 0)


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("link")
    parser.add_argument("firmware", type=autopilot_named)
    parser.add_argument("table")
    parser.add_argument("commit")
    parser.add_argument("file", type=Path)
    given = parser.parse_args()
    asked = Asked(given.link, given.firmware)
    record = {"autopilot": str(given.firmware), "table": given.table, "says": asked.says(), "commit": given.commit}
    rows: dict[str, str] = {}
    for command in COMMANDS:
        for frame in FRAMES:
            rows[f"{command} {int(frame)}"] = "".join(asked.letter(one) for one in row(command, frame))
    given.file.write_text(json.dumps(record | {"rows": rows}, indent=0) + "\n", encoding="utf-8")
    print(f"{record['says']}: {28 * len(rows)} verdicts")


if __name__ == "__main__":
    main()
