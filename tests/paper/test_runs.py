import json
import math
import multiprocessing
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from ipoa_mission.paper.reproduce import open_processes
from ipoa_mission.paper.runs import CHECKPOINTS, Trial, TrialRow, measure, read_rows, run_trial
from tests.refused import refuses

pytest.importorskip("minionpy")

SMALL = json.dumps({"iterations": 20, "population": 10})
TRIALS = [Trial("cec2022", function, 10, "poa", SMALL, 0, run) for run in range(2) for function in ("f1", "f2")]


class Here(Executor):
    def __init__(self, breaks_after: float = math.inf) -> None:
        self.count = 0
        self.breaks_after = breaks_after

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        if self.count >= self.breaks_after:
            future.set_exception(KeyboardInterrupt())
        else:
            self.count += 1
            future.set_result(fn(*args, **kwargs))
        return future


def results(rows: list[TrialRow]) -> list[tuple[object, ...]]:
    """Leave out seconds."""
    return [(r.trial, r.cost, r.evaluations, r.history, r.measures) for r in rows]


def test_a_row_holds_what_the_run_gave() -> None:
    row = run_trial(TRIALS[0])
    assert row.evaluations == 10 + 2 * 10 * 20
    assert len(row.history) == len(CHECKPOINTS)
    assert row.history[-1] == row.cost
    assert list(row.history) == sorted(row.history, reverse=True)


def test_a_trial_is_a_function_of_itself() -> None:
    assert results([run_trial(TRIALS[0])]) == results([run_trial(TRIALS[0])])


def test_written_runs_are_the_measured_ones(tmp_path: Path) -> None:
    rows = measure(TRIALS, tmp_path / "rows.csv", Here())
    assert [row.trial for row in rows] == TRIALS
    read = sorted(read_rows(tmp_path / "rows.csv"), key=lambda row: TRIALS.index(row.trial))
    assert [(r.trial, r.cost, r.evaluations) for r in read] == [(r.trial, r.cost, r.evaluations) for r in rows]
    for a, b in zip(read, rows, strict=True):
        assert a.history == pytest.approx(b.history, rel=1e-4)


def test_a_run_that_is_there_is_not_repeated(tmp_path: Path) -> None:
    measure(TRIALS[:3], tmp_path / "rows.csv", Here())
    executor = Here()
    assert [row.trial for row in measure(TRIALS, tmp_path / "rows.csv", executor)] == TRIALS
    assert executor.count == 1
    before = (tmp_path / "rows.csv").read_bytes()
    measure(TRIALS, tmp_path / "rows.csv", Here(breaks_after=0))
    assert (tmp_path / "rows.csv").read_bytes() == before


def test_an_interrupted_series_goes_on_where_it_stopped(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt):
        measure(TRIALS, tmp_path / "rows.csv", Here(breaks_after=2))
    kept = len(read_rows(tmp_path / "rows.csv"))
    assert kept <= 2
    executor = Here()
    assert len(measure(TRIALS, tmp_path / "rows.csv", executor)) == 4
    assert executor.count == 4 - kept


@pytest.mark.parametrize("cut", [1, 40, 200])
def test_a_line_that_was_cut_off_is_no_row_and_does_not_spoil_the_next(tmp_path: Path, cut: int) -> None:
    path = tmp_path / "rows.csv"
    whole = measure(TRIALS, path, Here())
    path.write_bytes(path.read_bytes()[:-cut])
    assert len(read_rows(path)) == 3
    again = measure(TRIALS, path, Here())
    assert [(r.trial, r.cost) for r in again] == [(r.trial, r.cost) for r in whole]
    assert {r.trial for r in read_rows(path)} == set(TRIALS)


def test_two_processes_do_not_add_to_the_same_file(tmp_path: Path) -> None:
    path = tmp_path / "rows.csv"

    def add_too(share: float, words: str) -> None:
        with refuses("in-use", "rows.csv"):
            measure(TRIALS, path, Here())

    measure(TRIALS, path, Here(), add_too)
    assert len(read_rows(path)) == len(TRIALS)
    measure(TRIALS, path, Here(breaks_after=0))


def test_waiting_runs_are_cancelled_when_the_series_is_stopped(tmp_path: Path) -> None:
    class Busy(Here):
        def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
            future: Future[Any] = super().submit(fn, *args, **kwargs) if not self.count else Future()
            waiting.append(future)
            return future

    def stop(share: float, words: str) -> None:
        if share > 0:
            raise KeyboardInterrupt

    waiting: list[Future[Any]] = []
    with pytest.raises(KeyboardInterrupt):
        measure(TRIALS, tmp_path / "rows.csv", Busy(), stop)
    assert [future.cancelled() for future in waiting] == [False, True, True, True]
    assert len(read_rows(tmp_path / "rows.csv")) == 1


def test_progress_is_told_from_what_was_there_to_the_end(tmp_path: Path) -> None:
    progress: list[str] = []
    measure(TRIALS[:1], tmp_path / "rows.csv", Here())
    measure(TRIALS, tmp_path / "rows.csv", Here(), lambda share, words: progress.append(words))
    assert progress == ["1 of 4", "2 of 4", "3 of 4", "4 of 4"]


def test_processes_give_the_same_rows(tmp_path: Path) -> None:
    trials = [*TRIALS, Trial("map", "map-6-1", 24, "ipoa", SMALL, 0, 0)]  # the last by linear algebra
    with open_processes(2) as processes:
        assert results(measure(trials, tmp_path / "a.csv", processes)) == results(
            measure(trials, tmp_path / "b.csv", Here())
        )


def test_a_killed_process_is_an_error_and_finished_runs_are_kept(tmp_path: Path) -> None:
    def kill(share: float, words: str) -> None:
        for process in multiprocessing.active_children() if share > 0 else ():
            process.kill()

    with refuses("process-killed"), open_processes(1) as processes:
        measure(TRIALS, tmp_path / "rows.csv", processes, kill)
    again = measure(TRIALS, tmp_path / "rows.csv", Here(breaks_after=len(TRIALS) - 1))
    assert [row.trial for row in again] == TRIALS


def test_threads_give_the_same_rows(tmp_path: Path) -> None:
    with ThreadPoolExecutor(2) as threads:
        assert results(measure(TRIALS, tmp_path / "a.csv", threads)) == results(
            measure(TRIALS, tmp_path / "b.csv", Here())
        )


@pytest.mark.parametrize(
    ("text", "message"), [("a,b\n", ("wrong-format",)), ("problem,case\n1,2\n", ("wrong-format",))]
)
def test_a_file_that_is_none_of_ours_is_refused(tmp_path: Path, text: str, message: tuple[str, ...]) -> None:
    (tmp_path / "rows.csv").write_text(text)
    with refuses(*message):
        read_rows(tmp_path / "rows.csv")


def test_a_row_that_makes_no_sense_is_named_by_its_line(tmp_path: Path) -> None:
    path = tmp_path / "rows.csv"
    measure(TRIALS[:2], path, Here())
    lines = path.read_text().splitlines(keepends=True)
    path.write_text(lines[0] + lines[1] + lines[2].replace(",10,", ",ten,", 1))
    with refuses("wrong-format"):
        read_rows(path)
