import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from ipoa_mission.errors import BadInput
from ipoa_mission.paper.reproduce import open_executor
from ipoa_mission.paper.rows import Trial, TrialRow, settings_text
from ipoa_mission.paper.runs import measure
from tests.refused import refuses

pytest.importorskip("minionpy")

SMALL = settings_text(population=10, iterations=30)
#: Runs of two functions, one by linear algebra, independent of the number of threads.
TRIALS = [Trial("cec2022", function, 10, "ipoa", SMALL, 0, run) for run in range(6) for function in ("f1", "f4")]
TRIALS.append(Trial("map", "map-6-1", 24, "adaptive-pelican", settings_text(evaluations=2000), 0, 0))


def results(rows: list[TrialRow]) -> list[tuple[object, ...]]:
    return [(r.trial, r.cost, r.evaluations, r.history) for r in rows]


@pytest.fixture(scope="module")
def local(tmp_path_factory: pytest.TempPathFactory) -> list[tuple[object, ...]]:
    with open_executor(2, None) as processes:
        return results(measure(TRIALS, tmp_path_factory.mktemp("local") / "rows.csv", processes))


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None, processes=True
    ) as running:
        yield running


@pytest.mark.long  # its workers need seconds to begin
@pytest.mark.filterwarnings("ignore")
def test_a_cluster_gives_the_rows_that_this_machine_gives(cluster: Any, local: object, tmp_path: Path) -> None:
    with open_executor(1, cluster.scheduler_address) as workers:
        assert results(measure(TRIALS, tmp_path / "rows.csv", workers)) == local


@pytest.mark.long  # its workers need seconds to begin
@pytest.mark.filterwarnings("ignore")
def test_a_worker_that_is_killed_in_the_middle_loses_nothing(cluster: Any, local: object, tmp_path: Path) -> None:
    killed: list[int] = []

    def kill_one(share: float, words: str) -> None:
        if words.startswith("2 of") and not killed:
            killed.append(next(iter(cluster.workers.values())).process.pid)
            os.kill(killed[0], signal.SIGKILL)

    with open_executor(1, cluster.scheduler_address) as workers:
        assert results(measure(TRIALS, tmp_path / "rows.csv", workers, kill_one)) == local
    assert killed


def test_unanswered_address_of_a_cluster_is_an_error(unused_port: int) -> None:
    pytest.importorskip("distributed")
    with (
        refuses("cluster-lost", "", f"tcp://127.0.0.1:{unused_port}"),
        open_executor(1, f"tcp://127.0.0.1:{unused_port}", patience_s=0.5),
    ):
        pass


@pytest.fixture
def unused_port() -> int:
    import socket

    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@pytest.mark.parametrize("address", ["localhost", "nonsense://x"])
def test_wrong_addresses_of_a_scheduler_are_bad_input(address: str) -> None:
    pytest.importorskip("distributed")
    with pytest.raises(BadInput), open_executor(1, address):
        pass
