"""Compare clients on a perfect link: items a second and CPU an item, with a server that does not limit them."""

import json
import shutil
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from pathlib import Path

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.simulator.faults import Faults
from tools import REPOSITORY
from tools.benchmarks.link_benchmark import speed_clients
from tools.benchmarks.link_benchmark.vehicle import vehicle

SOURCE = Path(__file__).with_name("mission_server.c")


def speed(
    autopilot: Autopilot, runs: int, items: int = 500, names: Sequence[str] = tuple(speed_clients.CLIENTS)
) -> str:
    """Return table rows, one a client: best and median of `runs` uploads."""
    took: dict[str, list[list[list[float]]]] = {name: [] for name in names}
    with ExitStack() as stack:
        serve = stack.enter_context(_servers(autopilot))
        clients = {
            name: stack.enter_context(_client(name, stack.enter_context(serve()), autopilot, items)) for name in names
        }
        for _ in range(runs):
            for name, client in clients.items():
                took[name].append(_once(client))
    return "\n".join(f"| {autopilot} | {name} | {_row(took[name], items)} |" for name in names)


HEADING = (
    "| autopilot | client | items/s to the Ack | CPU, µs/item | with reading back, items/s | CPU, µs/item |\n"
    "|---|---|---|---|---|---|"
)


def _row(took: list[list[list[float]]], items: int) -> str:
    cells = []
    for n in (0, 1):
        seconds, cpu = zip(*(one[n] for one in took), strict=True)
        cells.append(f"{items / min(seconds):.0f} ({items / statistics.median(seconds):.0f})")
        cells.append(f"{min(cpu) / items * 1e6:.0f} ({statistics.median(cpu) / items * 1e6:.0f})")
    return " | ".join(cells)


def _once(client: "subprocess.Popen[str]") -> list[list[float]]:
    assert client.stdin is not None
    assert client.stdout is not None
    client.stdin.write("go\n")
    client.stdin.flush()
    marks: list[list[float]] = json.loads(client.stdout.readline())
    return marks


@contextmanager
def _servers(autopilot: Autopilot) -> Iterator[Callable[[], AbstractContextManager[int]]]:
    """Yield a function that starts a vehicle and returns its port: in C if there is a compiler, else built in."""
    compiler = shutil.which("cc") or shutil.which("gcc")
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder) / "mission_server"
        if compiler is None:
            print("no C compiler: the built-in autopilot serves, and limits the quicker clients", file=sys.stderr)
        else:
            subprocess.run([compiler, "-O2", "-o", program, SOURCE], check=True)

        @contextmanager
        def serve() -> Iterator[int]:
            if compiler is None:
                with vehicle(autopilot, Faults(), 0) as (_, channel):
                    yield channel.port
                return
            command = [str(program), str(autopilot)]
            with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
                assert process.stdout is not None
                try:
                    yield int(process.stdout.readline())
                finally:
                    process.kill()

        yield serve


@contextmanager
def _client(name: str, port: int, autopilot: Autopilot, items: int) -> "Iterator[subprocess.Popen[str]]":
    command = [sys.executable, "-m", speed_clients.__name__, name, str(port), str(autopilot), str(items)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=REPOSITORY) as process:
        assert process.stdout is not None
        try:
            while process.stdout.readline().strip() != "ready":
                if process.poll() is not None:
                    raise SystemExit(f"{name}: does not connect")
            yield process
        finally:
            process.kill()
