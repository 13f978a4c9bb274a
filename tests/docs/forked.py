"""Run `ipoa-mission` as a shell command, forked from a process that has imported all.

with forked(folder) as programs: subprocess.run([str(programs.usual / "ipoa-mission"), "show", "campus.plan"])
"""

import json
import os
import pkgutil
import signal
import socket
import subprocess
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

import ipoa_mission
from tests.quick_link import hurry
from tests.quick_search import search_quickly

#: Hands on its input, waits, and passes signals on to the working process.
CLIENT = """#!{python} -IS
import json, os, signal, socket, sys
there = socket.socket(socket.AF_UNIX)
there.connect({address!r})
request = json.dumps([{quick}, sys.argv[1:], os.getcwd(), dict(os.environ)]).encode()
socket.send_fds(there, [len(request).to_bytes(4, "big") + request], [0, 1, 2])
answers = there.makefile()
process = int(answers.readline())
for number in (signal.SIGINT, signal.SIGTERM):
    signal.signal(number, lambda number, frame: os.kill(process, number))
sys.exit(int(answers.readline() or 1))
"""


class Programs(NamedTuple):
    """Two folders with an `ipoa-mission`; `quick` plans as `tests.quick_search` does."""

    usual: Path
    quick: Path


@contextmanager
def forked(folder: Path) -> Iterator[Programs]:
    address, programs = folder / "forked.socket", Programs(folder / "usual", folder / "quick")
    with subprocess.Popen([sys.executable, "-m", "tests.docs.forked", str(address)], stdout=subprocess.PIPE) as server:
        assert server.stdout is not None
        assert server.stdout.readline() == b"ready\n"
        for there in programs:
            there.mkdir()
            client = CLIENT.format(python=sys.executable, address=str(address), quick=there == programs.quick)
            (there / "ipoa-mission").write_text(client, encoding="utf-8")
            (there / "ipoa-mission").chmod(0o755)
        try:
            yield programs
        finally:
            server.terminate()


#: Unneeded by the docs, or starts threads, which a fork would lose.
LEFT_OUT = ("__main__", "paper", "link.mavsdk_backend", "studio")


def serve(address: str) -> None:
    for module in pkgutil.walk_packages(ipoa_mission.__path__, "ipoa_mission."):
        if not module.name.removeprefix("ipoa_mission.").startswith(LEFT_OUT):
            import_module(module.name)
    from ipoa_mission.cli.app import main

    hurry()
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # nobody waits for them but their clients
    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind(address)
        listening.listen()
        print("ready", flush=True)
        while True:
            client, _ = listening.accept()
            if os.fork() == 0:
                signal.signal(signal.SIGCHLD, signal.SIG_DFL)
                listening.close()
                _run(client, main)
            client.close()


def _run(client: socket.socket, main: object) -> None:
    code = 1
    try:
        data, streams, *_ = socket.recv_fds(client, 1 << 20, 3)
        while len(data) < 4 + int.from_bytes(data[:4], "big"):
            data += client.recv(1 << 20)
        quick, arguments, here, environment = json.loads(data[4:])
        if quick:
            search_quickly()
        for number, stream in enumerate(streams):
            os.dup2(stream, number)
            os.close(stream)
        sys.stdin, sys.stdout, sys.stderr = open(0), open(1, "w"), open(2, "w")  # noqa: SIM115
        os.chdir(here)
        os.environ.clear()
        os.environ.update(environment)
        client.sendall(f"{os.getpid()}\n".encode())
        sys.argv = ["ipoa-mission", *arguments]
        assert callable(main)
        main()
        code = 0
    except SystemExit as ended:
        code = ended.code if isinstance(ended.code, int) else int(ended.code is not None)
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        client.sendall(f"{code}\n".encode())
        os._exit(code)


if __name__ == "__main__":
    serve(sys.argv[1])
