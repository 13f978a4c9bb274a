import signal
from collections.abc import Iterator
from concurrent.futures import CancelledError, Executor, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager

from ipoa_mission.errors import BadInput, MissionError, imported


@contextmanager
def open_executor(jobs: int, address: str | None, patience_s: float = 10.0) -> Iterator[Executor]:
    """Open `jobs` local processes, or the workers of the Dask scheduler at `address`. Raises BadInput, MissionError."""
    if jobs < 1:
        raise BadInput(f"expected at least 1, not {jobs}", place="jobs")
    if address is None:
        try:
            with ProcessPoolExecutor(jobs, initializer=_leave_ctrl_c_to_the_parent) as pool:
                yield pool
        except BrokenProcessPool as error:
            raise MissionError(
                "a process that ran trials was killed",
                hint="perhaps by lack of memory; the same command continues",
                code="cluster-lost",
            ) from error
        return
    needed = "an executor on a cluster needs Dask distributed, which is not installed"
    distributed = imported("distributed", needed, "cluster")
    if "://" not in address:
        raise BadInput(f"expected a scheduler such as tcp://10.0.0.1:8786, not {address!r}", place="executor")
    try:
        client = distributed.Client(address, timeout=patience_s, set_as_default=False)
    except ValueError as error:
        message = f"expected a scheduler such as tcp://10.0.0.1:8786, not {address!r}"
        raise BadInput(message, place="executor") from error
    except OSError as error:
        raise MissionError(
            f"no Dask scheduler answers at {address}",
            hint="start one with: dask scheduler, and its workers",
            code="cluster-lost",
        ) from error
    try:
        with client, client.get_executor(pure=False, retries=10) as pool:
            yield pool
    except (CancelledError, distributed.KilledWorker) as error:
        words = f"the cluster at {address} was lost while it ran trials"
        raise MissionError(words, hint="the same command continues where it stopped", code="cluster-lost") from error


def _leave_ctrl_c_to_the_parent() -> None:
    """Ignore Ctrl-C in workers; the parent stops the work."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
