"""Upload a mission over bad radios by our client, MAVSDK and MAVProxy to the built-in autopilot.

    python -m tools.benchmarks.link                        what the rows of docs/link/uploads.csv still lack
    python -m tools.benchmarks.link --table                the tables of docs/lab/link.md, from those rows
    python -m tools.benchmarks.link --fast-path            ArduPilot's mission file against items, on a virtual clock
    python -m tools.benchmarks.link --clean --runs 20      client beside client over a perfect link, to a server in C
    python -m tools.benchmarks.link --runs 5 --loss 0 30 --rows new.csv

Each upload has its own autopilot, UDP socket and radio, in real time. Several run at once, because they mostly wait;
those over a perfect link run alone. A run is exact if the client reports success within its time limit and the
autopilot holds every item to the last 1e-7 degree. Runs off by one such unit are "near"; other reported successes are
false. Times are from the upload's start to the final MISSION_ACK at the client; ours also until reading back and
comparing, which the others omit. Bytes are those of mission messages, both ways, until the vehicle's first MISSION_ACK.
Every client has its own process (over a perfect link a new one for each upload); connecting is not counted. A rerun
continues after the last row.
"""

import importlib.util
import itertools
from pathlib import Path

from ipoa_mission.autopilot.autopilot import Autopilot, autopilot_named, registered
from tools import REPOSITORY, command_line
from tools.benchmarks.link_benchmark.measure import complete, fast_path
from tools.benchmarks.link_benchmark.rows import CLIENTS, Cell, read_rows
from tools.benchmarks.link_benchmark.speed import HEADING, speed
from tools.benchmarks.link_benchmark.tell import table

ROWS = REPOSITORY / "docs" / "link" / "uploads.csv"


def main() -> None:
    """Run the missing uploads, or print the tables."""
    parser = command_line(__doc__)
    parser.add_argument("--runs", type=int, default=50)
    parser.add_argument("--mavproxy-runs", type=int, default=10)
    parser.add_argument("--at-once", type=int, default=10)
    parser.add_argument("--delay", type=float, nargs="+", default=[0, 50, 200], help="one way, ms")
    parser.add_argument("--loss", type=float, nargs="+", default=[0, 5, 20, 30], help="each way, per cent")
    parser.add_argument("--clients", nargs="+", choices=CLIENTS, default=list(CLIENTS))
    parser.add_argument("--autopilots", nargs="+", type=autopilot_named, default=list(registered()))
    parser.add_argument("--rows", type=Path, default=ROWS)
    parser.add_argument("--table", action="store_true")
    parser.add_argument("--fast-path", action="store_true")
    parser.add_argument("--clean", action="store_true")
    arguments = parser.parse_args()
    if arguments.clean:
        print(HEADING)
        for autopilot in arguments.autopilots:
            print(speed(autopilot, arguments.runs), flush=True)
        return
    if arguments.fast_path:
        print("| delay, ms | loss, % | item by item, s | as one file, s | times as quick |\n|---|---|---|---|---|")
        for delay_ms, loss in itertools.product((50, 200), arguments.loss):
            print(fast_path(delay_ms, loss, arguments.runs), flush=True)
        return
    if arguments.table:
        for autopilot in arguments.autopilots:
            print(f"{autopilot}:\n\n{table(read_rows(arguments.rows), autopilot)}\n")
        return
    needs = {"mavsdk": "mavsdk", "mavproxy": "MAVProxy"}
    clients = [one for one in arguments.clients if one not in needs or importlib.util.find_spec(needs[one])]
    for autopilot, delay_ms, loss, client in itertools.product(
        arguments.autopilots, arguments.delay, arguments.loss, clients
    ):
        if client == "by-file" and autopilot is not Autopilot.ARDUPILOT:
            continue
        runs = arguments.mavproxy_runs if client == "mavproxy" else arguments.runs
        complete(Cell(autopilot, float(delay_ms), float(loss), client), runs, arguments.at_once, arguments.rows)


if __name__ == "__main__":
    main()
