"""Measure uploads over bad radios, and as one file."""

import statistics
import sys
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import closing
from pathlib import Path

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.link import connect as link_connect
from ipoa_mission.link.codec import Codec
from ipoa_mission.link.line import Line
from ipoa_mission.link.loopback import Loopback
from ipoa_mission.link.messages import MissionType
from ipoa_mission.mission.items import Item
from ipoa_mission.mission.stored_mission import compare, to_wire
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot as Mock
from ipoa_mission.simulator.faults import BadPipe, Faults
from ipoa_mission.simulator.station import Station
from tools.benchmarks.link_benchmark.clients import NotConnected, mavproxy
from tools.benchmarks.link_benchmark.rows import Cell, Run, add_row, read_rows
from tools.benchmarks.link_benchmark.vehicle import HOME, mission, vehicle
from tools.benchmarks.link_benchmark.workers import Workers

ITEMS = 20


def run(cell: Cell, seed: int, workers: Workers) -> Run:
    """Run one upload, again if the client did not find the vehicle."""
    for _ in range(4):
        try:
            return attempt(cell, seed, workers)
        except NotConnected as error:
            print(f"{cell}, seed {seed}: not connected: {error}", file=sys.stderr)
    raise SystemExit(f"{cell}: the client does not connect")


def attempt(cell: Cell, seed: int, workers: Workers) -> Run:
    """Run one upload.

    Raises:
        NotConnected: the client does not connect.
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
    """Return whether every item is there, at most one unit of 1e-7 degree off."""
    return len(sent) == len(held) and all(
        one.command == other.command
        and abs(one.latitude_deg - other.latitude_deg) < 1.6e-7
        and abs(one.longitude_deg - other.longitude_deg) < 1.6e-7
        for one, other in zip(sent, held, strict=True)
    )


def complete(cell: Cell, runs: int, at_once: int, path: Path) -> None:
    """Make the runs of a cell that the file lacks."""
    there = {one.seed for one in read_rows(path) if one.cell == cell}
    missing = [seed for seed in range(runs) if seed not in there]
    is_perfect = not (cell.delay_ms or cell.loss_percent)
    workers = Workers(cell.client, is_reused=not is_perfect and cell.client != "mavsdk")
    with closing(workers), ThreadPoolExecutor(1 if is_perfect else at_once) as pool:
        for done in as_completed([pool.submit(run, cell, seed, workers) for seed in missing]):
            add_row(path, done.result())
    print(f"{cell}: {len(missing)} runs more, {len(there)} were there", flush=True)


def fast_path(delay_ms: float, loss: float, runs: int) -> str:
    """Return a table row of ArduPilot's fast path: 100 items, verified, on a virtual clock; all must be exact."""
    sent = to_wire(mission(Autopilot.ARDUPILOT, 100))
    medians = []
    for fast in (False, True):
        took = []
        for seed in range(runs):
            faults = Faults(loss=loss / 100, delay_s=delay_ms / 1000)
            mock = Mock(Autopilot.ARDUPILOT, HOME)
            channel = Loopback(Station(mock), BadPipe(faults, 2 * seed), BadPipe(faults, 2 * seed + 1))
            here = link_connect.meet(Line(channel, Codec(245, 190)), fast=fast)
            begun = channel.now()
            here.upload_items(sent, MissionType.MISSION)
            took.append(channel.now() - begun)
            assert compare(sent, mock.transfers.listed(MissionType.MISSION), Autopilot.ARDUPILOT) is None
        medians.append(statistics.median(took))
    slow, quick = medians
    return f"| {delay_ms:g} | {loss:g} | {slow:.1f} | {quick:.1f} | {slow / quick:.1f} |"
