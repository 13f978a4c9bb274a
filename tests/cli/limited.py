"""Run a function in its own process, with limits of CPU time and memory."""

import contextlib
import os
import resource
import signal
import sys
import tempfile
import threading
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

ADDRESSES = 4 << 30  # address space of a process [bytes]; its real use is counted apart
WAITS = 10  # wall time limit, in units of the CPU time limit


@dataclass(frozen=True)
class Ended:
    """Describe the end of a run: exit code, output, CPU time [s] and additional memory [MB].

    `killed` names the limit, if any.
    """

    code: int
    out: str
    err: str
    seconds: float
    megabytes: float
    killed: str = ""


def run_limited(act: Callable[[], None], seconds: float) -> Ended:
    """Call `act` in a fork of this process with its output captured, for `seconds` of CPU at most.

    The fork has all modules imported already.
    """
    with tempfile.TemporaryDirectory() as folder:
        out, err, before = (Path(folder) / name for name in ("out", "err", "before"))
        sys.stdout.flush()
        sys.stderr.flush()
        child = os.fork()
        if child == 0:
            before.write_text(str(_most_memory()), encoding="utf-8")
            os._exit(_inside(act, seconds, out, err))
        watch = threading.Timer(seconds * WAITS, _kill, [child])
        watch.start()
        _, status, used = os.wait4(child, 0)
        watch.cancel()
        code = os.waitstatus_to_exitcode(status)
        took = used.ru_utime + used.ru_stime
        killed = "" if code >= 0 else f"took more than {seconds:g} s" if took > seconds * 0.9 else _signal(-code)
        output, mistakes = (path.read_text(encoding="utf-8", errors="replace") for path in (out, err))
        return Ended(code, output, mistakes, took, (used.ru_maxrss - int(before.read_text("utf-8"))) / 1024, killed)


def _most_memory() -> int:
    """Return the peak memory of this process [kB]; a fork begins with its parent's."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def _inside(act: Callable[[], None], seconds: float, out: Path, err: Path) -> int:
    for path, stream in ((out, 1), (err, 2)):
        os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT), stream)
    sys.stdout, sys.stderr = (open(stream, "w", closefd=False, errors="replace") for stream in (1, 2))  # noqa: SIM115
    resource.setrlimit(resource.RLIMIT_AS, (ADDRESSES, ADDRESSES))
    resource.setrlimit(resource.RLIMIT_CPU, (int(seconds), int(seconds) + 1))
    signal.signal(signal.SIGXCPU, signal.SIG_DFL)
    try:
        act()
        code = 0
    except SystemExit as stopped:
        code = stopped.code if isinstance(stopped.code, int) else int(stopped.code is not None)
    except BaseException:
        traceback.print_exc()
        code = 70
    sys.stdout.flush()
    sys.stderr.flush()
    return code


def _kill(child: int) -> None:
    with contextlib.suppress(ProcessLookupError):
        os.kill(child, signal.SIGKILL)


def _signal(number: int) -> str:
    return f"ended by {signal.Signals(number).name}"
