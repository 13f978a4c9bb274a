"""Upload one mission over bad radios with our client, MAVSDK and MAVProxy, side by side, to the built-in autopilot.

    python tools/benchmark_link.py                        what the rows of docs/link/uploads.csv still lack
    python tools/benchmark_link.py --table                the tables of docs/link.md, from those rows
    python tools/benchmark_link.py --fast-path            ArduPilot's mission file against items, on a virtual clock
    python tools/benchmark_link.py --clean                ours and MAVSDK by turns, 200 items over a perfect link
    python tools/benchmark_link.py --runs 5 --loss 0 30 --rows new.csv

Each upload has an autopilot, a UDP socket and a radio of its own, in real time. Several run at once, for they mostly
wait; those over a perfect link run alone. A run is exact when the client says "done" within its time limit AND the
autopilot holds every item to the last 1e-7 degree; those that are off by one such unit are "near"; anything else that
was called done is false. Times are from the order to upload until the client has the final MISSION_ACK; ours is given
a second time with reading back and comparing, which the others leave out. Bytes are those of mission messages, both
ways, until the vehicle's first MISSION_ACK. Every client has a process of its own (over a perfect link a
new one for each upload); connecting is not counted. Rows are written as they come, and a rerun goes on where the last
one stopped.
"""

import argparse
import csv
import importlib.util
import itertools
import json
import os
import queue
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import ExitStack, closing, contextmanager
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path

from ipoa_mission.errors import MissionError
from ipoa_mission.link import mavsdk_backend
from ipoa_mission.link import vehicle as vehicle_module
from ipoa_mission.link.address import parse_address
from ipoa_mission.link.channel import Peer, UdpChannel
from ipoa_mission.link.codec import Codec
from ipoa_mission.link.line import Line
from ipoa_mission.link.loopback import Loopback
from ipoa_mission.link.messages import MissionType
from ipoa_mission.mission.firmware import compare, to_wire
from ipoa_mission.mission.items import Item, Mission, return_to_launch, takeoff, waypoint
from ipoa_mission.simulator.autopilot import Autopilot as Mock
from ipoa_mission.simulator.faults import BadPipe, Faults
from ipoa_mission.simulator.server import Server
from ipoa_mission.simulator.station import Station
from ipoa_mission.vehicle import Autopilot
from ipoa_mission.world.frame import Geodetic

HOME = Geodetic(47.4, 8.5, 400.0)
MISSION_MESSAGES = frozenset({39, 40, 43, 44, 47, 51, 73, 110})
CLIENTS = ("ours", "by-file", "mavsdk", "mavproxy")
ROWS = Path(__file__).parents[1] / "docs" / "link" / "uploads.csv"
ITEMS = 20
LIMIT_S = 240.0


@dataclass(frozen=True)
class Cell:
    """One client with one autopilot over one radio."""

    autopilot: Autopilot
    delay_ms: float  # one way
    loss_percent: float  # each way
    client: str


@dataclass(frozen=True)
class Run:
    """One upload: what the client said, what the autopilot holds, and what it took. A row of the file."""

    autopilot: str
    delay_ms: float
    loss_percent: float
    client: str
    seed: int
    said: bool
    exact: bool
    near: bool  # exact but for one unit of 1e-7 degree
    seconds: float
    verified_s: float | None
    bytes: int

    @property
    def cell(self) -> Cell:
        """Which cell of the table it belongs to."""
        return Cell(Autopilot(self.autopilot), self.delay_ms, self.loss_percent, self.client)


class NotConnected(Exception):
    """The client did not get as far as an upload."""


class CountingChannel(UdpChannel):
    """Counts the bytes of mission messages."""

    counted = 0
    ended = False

    def receive(self, until: float) -> list[tuple[bytes, Peer]]:
        """Count what comes in."""
        got = super().receive(until)
        for data, _ in got:
            self._count(data)
        return got

    def send(self, data: bytes, peer: Peer | None) -> None:
        """Count what goes out."""
        self._count(data)
        self.ended = self.ended or data[7:10] == b"\x2f\0\0"  # MISSION_ACK
        super().send(data, peer)

    def _count(self, data: bytes) -> None:
        number = int.from_bytes(data[7:10], "little") if data[:1] == b"\xfd" else data[5]
        if number in MISSION_MESSAGES and not self.ended:
            self.counted += len(data)


def mission(autopilot: Autopilot, items: int) -> Mission:
    """A mission of so many items whose coordinates need every digit, and whose params every client's file can hold."""
    legs = [waypoint(Geodetic(47.4 + 0.000123457 * n, 8.5 - 0.000098763 * n), 30.0) for n in range(1, items - 1)]
    items = (takeoff(HOME, 20.0), *legs, return_to_launch())
    return Mission(HOME, tuple(replace(item, params=(0.0,) * 4) for item in items), autopilot)


@contextmanager
def vehicle(autopilot: Autopilot, faults: Faults, seed: int) -> Iterator[tuple[Mock, CountingChannel]]:
    """A built-in autopilot behind a bad radio."""
    channel = CountingChannel(parse_address("udpin:127.0.0.1:0"))
    mock = Mock(autopilot, HOME)
    server = Server(channel, Station(mock), 1.0, faults, seed)
    stop = threading.Event()
    thread = threading.Thread(target=server.run, args=(stop.is_set,))
    thread.start()
    try:
        yield mock, channel
    finally:
        stop.set()
        thread.join()
        channel.close()


class Worker:
    """A client in a process of its own that makes one upload after the other."""

    def __init__(self, client: str) -> None:
        command = [sys.executable, __file__, "--as", client]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
        )

    def upload(self, port: int, sent: Mission) -> tuple[bool, float, float | None]:
        """Said, seconds to the Ack, seconds till verified.

        Raises:
            NotConnected: it did not get that far; the worker has ended.
        """
        pipe = self._process.stdin, self._process.stderr
        assert pipe[0] is not None
        assert pipe[1] is not None
        timer = threading.Timer(LIMIT_S + 60, self._process.kill)
        timer.start()
        pipe[0].write(f"{port} {sent.autopilot} {len(sent.items)}\n")
        pipe[0].flush()
        words = []
        for line in pipe[1]:
            if line.startswith("RESULT "):
                timer.cancel()
                said, seconds, verified_s = json.loads(line[7:])
                return said, seconds, verified_s
            words.append(line)
        is_late = not timer.is_alive()
        timer.cancel()
        if is_late:
            return False, LIMIT_S, None
        raise NotConnected("".join(words)[-500:])

    def close(self) -> None:
        """End the process."""
        with self._process:
            self._process.kill()


class Workers:
    """A worker for each thread, used again and again, or a new one for each upload."""

    def __init__(self, client: str, is_reused: bool) -> None:
        self._client = client
        self._is_reused = is_reused
        self._mine = threading.local()
        self._all: list[Worker] = []

    def upload(self, port: int, sent: Mission) -> tuple[bool, float, float | None]:
        """See `Worker`."""
        worker = getattr(self._mine, "worker", None) or Worker(self._client)
        self._mine.worker = worker
        self._all.append(worker)
        is_usable = False
        try:
            result = worker.upload(port, sent)
            is_usable = self._is_reused
            return result
        finally:
            if not is_usable:
                worker.close()
                self._mine.worker = None

    def close(self) -> None:
        """End them all."""
        for worker in self._all:
            worker.close()


def ours(port: str, sent: Mission, fast: bool = False) -> tuple[bool, float, float | None]:
    """Our client's upload, in the process of the client; `fast`: ArduPilot's mission file."""
    acknowledged: list[float] = []

    def note(done: int, total: int) -> None:
        if done == total and not acknowledged:
            acknowledged.append(time.monotonic())

    vehicle_module.PRESENCE_S = 60.0
    with vehicle_module.connect(f"udpout:127.0.0.1:{port}", fast=fast) as here:
        items = to_wire(sent)
        begun = time.monotonic()
        try:
            here.upload_items(items, MissionType.MISSION, note)
        except MissionError:
            return False, LIMIT_S, None
        verified = time.monotonic()
    return True, (acknowledged or [verified])[0] - begun, verified - begun


def by_file(port: str, sent: Mission) -> tuple[bool, float, float | None]:
    """Our client's fast path; its time is that of the last piece written, its bytes those of reading back, too."""
    return ours(port, sent, fast=True)


def mavsdk(port: str, sent: Mission) -> tuple[bool, float, float | None]:
    """MAVSDK's own upload, in the process of the client."""
    mavsdk_backend.PRESENCE_S = 60.0
    with mavsdk_backend.connect(f"udpout:127.0.0.1:{port}") as here:
        rows = [here._spell(seq, item, 0) for seq, item in enumerate(to_wire(sent))]
        begun = time.monotonic()
        try:
            here._raw.upload_mission(rows)
        except here._refused:
            return False, LIMIT_S, None
        return True, time.monotonic() - begun, None


def mavproxy(port: int, sent: Mission) -> tuple[bool, float, float | None]:
    """The same by MAVProxy, in a process of its own, from a file with seven decimals."""
    rows = ["QGC WPL 110"]
    wire = to_wire(sent)
    for seq, item in enumerate(wire):
        place = f"{item.latitude_deg:.7f}\t{item.longitude_deg:.7f}\t{item.altitude:.6f}"
        rows.append(f"{seq}\t{int(seq == 0)}\t{item.frame}\t{item.command}\t0\t0\t0\t0\t{place}\t1")
    script = Path(sys.executable).parent / "mavproxy.py"
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "mission.txt"
        path.write_text("\n".join(rows) + "\n")
        command = [sys.executable, "-u", str(script), f"--master=udpout:127.0.0.1:{port}"]
        with subprocess.Popen(
            [*command, f"--state-basedir={folder}", "--default-modules=wp"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            cwd=folder,
            env={**os.environ, "HOME": folder},
        ) as process:
            lines: queue.Queue[str] = queue.Queue()
            assert process.stdout is not None
            assert process.stdin is not None
            threading.Thread(target=lambda: [lines.put(line) for line in process.stdout or ()], daemon=True).start()
            try:
                if not _until(lines, "online system", 60.0):
                    raise NotConnected("MAVProxy heard nobody")
                begun = time.monotonic()
                process.stdin.write(f"wp load {path}\n")
                process.stdin.flush()
                said = _until(lines, "MISSION_ACK: TYPE_MISSION: ACCEPTED", 60.0)
                return said, time.monotonic() - begun, None
            finally:
                process.kill()


def _until(lines: "queue.Queue[str]", words: str, seconds: float) -> bool:
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        try:
            if words in lines.get(timeout=0.05):
                return True
        except queue.Empty:
            continue
    return False


def run(cell: Cell, seed: int, workers: Workers) -> Run:
    """One upload; a client that did not find the vehicle gets another chance."""
    for _ in range(4):
        try:
            return attempt(cell, seed, workers)
        except NotConnected as error:
            print(f"{cell}, seed {seed}: not connected: {error}", file=sys.stderr)
    raise SystemExit(f"{cell}: the client does not connect")


def attempt(cell: Cell, seed: int, workers: Workers) -> Run:
    """One upload, if the client connects.

    Raises:
        NotConnected: it does not.
    """
    sent = mission(cell.autopilot, ITEMS)
    faults = Faults(loss=cell.loss_percent / 100, delay_s=cell.delay_ms / 1000)
    with vehicle(cell.autopilot, faults, seed) as (mock, channel):
        upload = mavproxy if cell.client == "mavproxy" else workers.upload
        said, seconds, verified_s = upload(channel.port, sent)
        held = mock.transfers.listed(MissionType.MISSION)
    exact = compare(to_wire(sent), held, cell.autopilot) is None
    near = exact or is_near(to_wire(sent), held)
    place = (str(cell.autopilot), cell.delay_ms, cell.loss_percent, cell.client, seed)
    verified = None if verified_s is None else round(verified_s, 4)
    return Run(*place, said, exact, near, round(seconds, 4), verified, channel.counted)


def is_near(sent: tuple[Item, ...], held: tuple[Item, ...]) -> bool:
    """Whether every item is there, at most one unit of 1e-7 degree off."""
    return len(sent) == len(held) and all(
        one.command == other.command
        and abs(one.latitude_deg - other.latitude_deg) < 1.6e-7
        and abs(one.longitude_deg - other.longitude_deg) < 1.6e-7
        for one, other in zip(sent, held, strict=True)
    )


def read_rows(path: Path) -> list[Run]:
    """The runs so far."""
    if not path.exists():
        return []
    with path.open(newline="") as file:
        return [
            Run(
                row["autopilot"],
                float(row["delay_ms"]),
                float(row["loss_percent"]),
                row["client"],
                int(row["seed"]),
                row["said"] == "True",
                row["exact"] == "True",
                row["near"] == "True",
                float(row["seconds"]),
                float(row["verified_s"]) if row["verified_s"] else None,
                int(row["bytes"]),
            )
            for row in csv.DictReader(file)
        ]


def add_row(path: Path, done: Run) -> None:
    """Write one run behind the others."""
    path.parent.mkdir(parents=True, exist_ok=True)
    is_new = not path.exists()
    with path.open("a", newline="") as file:
        writer = csv.DictWriter(file, [field.name for field in fields(Run)], lineterminator="\n")
        if is_new:
            writer.writeheader()
        writer.writerow(asdict(done))


def complete(cell: Cell, runs: int, at_once: int, path: Path) -> None:
    """Make the runs of a cell that are not in the file yet."""
    there = {one.seed for one in read_rows(path) if one.cell == cell}
    missing = [seed for seed in range(runs) if seed not in there]
    is_perfect = not (cell.delay_ms or cell.loss_percent)
    workers = Workers(cell.client, is_reused=not is_perfect and cell.client != "mavsdk")
    with closing(workers), ThreadPoolExecutor(1 if is_perfect else at_once) as pool:
        for done in as_completed([pool.submit(run, cell, seed, workers) for seed in missing]):
            add_row(path, done.result())
    print(f"{cell}: {len(missing)} runs more, {len(there)} were there", flush=True)


def told(runs: list[Run]) -> str:
    """A cell of the table: exact of all (near ones, false ones), median seconds, items a second, bytes an item."""
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
    """The rows of one autopilot in Markdown: a line for each radio, a column for each client."""
    mine = [one for one in rows if one.autopilot == str(autopilot)]
    clients = [client for client in CLIENTS if any(one.client == client for one in mine)]
    lines = [f"| delay, ms | loss, % | {' | '.join(clients)} |", "|---" * (2 + len(clients)) + "|"]
    for delay_ms, loss in sorted({(one.delay_ms, one.loss_percent) for one in mine}):
        cells = [told([one for one in mine if one.cell == Cell(autopilot, delay_ms, loss, name)]) for name in clients]
        lines.append(f"| {delay_ms:g} | {loss:g} | {' | '.join(cells)} |")
    return "\n".join(lines)


def clean(autopilot: Autopilot, runs: int, items: int = 200) -> str:
    """A row of the table of clean links: items a second to the Ack, the best and the median of so many by turns."""
    clients = [one for one in CLIENTS[:3] if one != "by-file" or autopilot is Autopilot.ARDUPILOT]
    took: dict[str, list[float]] = {client: [] for client in clients}
    with ExitStack() as stack:
        workers = {client: stack.enter_context(closing(Worker(client))) for client in clients}
        for seed in range(runs):
            for client, worker in workers.items():
                with vehicle(autopilot, Faults(), seed) as (_, channel):
                    said, seconds, _ = worker.upload(channel.port, mission(autopilot, items))
                assert said
                took[client].append(seconds)
    rates = [f"{items / min(took[one]):.0f} ({items / statistics.median(took[one]):.0f})" for one in clients]
    return f"| {autopilot} | {' | '.join(rates if len(rates) == 3 else (rates[0], '', rates[1]))} |"


def fast_path(delay_ms: float, loss: float, runs: int) -> str:
    """A row of the table of ArduPilot's fast path: 100 items, verified, on a virtual clock; all must be exact."""
    sent = to_wire(mission(Autopilot.ARDUPILOT, 100))
    medians = []
    for fast in (False, True):
        took = []
        for seed in range(runs):
            faults = Faults(loss=loss / 100, delay_s=delay_ms / 1000)
            mock = Mock(Autopilot.ARDUPILOT, HOME)
            channel = Loopback(Station(mock), BadPipe(faults, 2 * seed), BadPipe(faults, 2 * seed + 1))
            here = vehicle_module.meet(Line(channel, Codec(245, 190)), fast=fast)
            begun = channel.now()
            here.upload_items(sent, MissionType.MISSION)
            took.append(channel.now() - begun)
            assert compare(sent, mock.transfers.listed(MissionType.MISSION), Autopilot.ARDUPILOT) is None
        medians.append(statistics.median(took))
    slow, quick = medians
    return f"| {delay_ms:g} | {loss:g} | {slow:.1f} | {quick:.1f} | {slow / quick:.1f} |"


def main() -> None:
    """Run what is missing, or print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=50)
    parser.add_argument("--mavproxy-runs", type=int, default=10)
    parser.add_argument("--at-once", type=int, default=10)
    parser.add_argument("--delay", type=float, nargs="+", default=[0, 50, 200], help="one way, ms")
    parser.add_argument("--loss", type=float, nargs="+", default=[0, 5, 20, 30], help="each way, per cent")
    parser.add_argument("--clients", nargs="+", choices=CLIENTS, default=list(CLIENTS))
    parser.add_argument("--autopilots", nargs="+", type=Autopilot, default=list(Autopilot))
    parser.add_argument("--rows", type=Path, default=ROWS)
    parser.add_argument("--table", action="store_true")
    parser.add_argument("--fast-path", action="store_true")
    parser.add_argument("--clean", action="store_true")
    arguments = parser.parse_args()
    if arguments.clean:
        print("| autopilot | ours | by-file | mavsdk |\n|---|---|---|---|")
        for autopilot in arguments.autopilots:
            print(clean(autopilot, arguments.runs), flush=True)
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
    if sys.argv[1:2] == ["--as"]:
        act = {"ours": ours, "by-file": by_file, "mavsdk": mavsdk}[sys.argv[2]]
        for asked in sys.stdin:
            port, family, count = asked.split()
            result = act(port, mission(Autopilot(family), int(count)))
            sys.stderr.write("\nRESULT " + json.dumps(result) + "\n")
            sys.stderr.flush()
    else:
        main()
