import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import typer

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.cli.app import command
from ipoa_mission.geodesy import Geodetic
from ipoa_mission.link.channel import UdpChannel, parse_address
from ipoa_mission.simulator.built_in_autopilot import BuiltInAutopilot as Mock
from ipoa_mission.simulator.station import Faults, Server, Station
from tests.link_pair import port_of

MISSIONS = Path(__file__).parents[2] / "missions"
FOR_ARDUPILOT, FOR_PX4 = str(MISSIONS / "campus.plan"), str(MISSIONS / "sitl.plan")
LARGE = {
    *("numpy", "scipy", "shapely", "pyproj", "pydantic", "matplotlib", "contourpy"),
    *("numba", "pymavlink", "mavsdk", "rasterio"),
}
#: Slow imports of ours.
OURS = {"ipoa_mission.scenario", "ipoa_mission.planning", "ipoa_mission.simulator", "ipoa_mission.report.page"}
#: Runs command lines, and prints the imports after each.
WATCHED = f"""
import sys
from ipoa_mission.cli.app import main
for line in sys.argv[1].splitlines():
    sys.argv = ["ipoa-mission", *line.split()]
    try:
        main()
    except SystemExit as ended:
        assert not ended.code, line
    sys.__stderr__.write("IMPORTED " + " ".join(p for p in {sorted(LARGE | OURS)!r} if p in sys.modules) + "\\n")
"""


def imported(*lines: str, before: str = "") -> list[set[str]]:
    """Return the imports after each of these command lines."""
    run = subprocess.run(
        [sys.executable, "-c", before + WATCHED, "\n".join(lines)],
        capture_output=True, text=True, timeout=300, cwd=MISSIONS.parent,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
    imported_names = [set(line.split()[1:]) for line in run.stderr.splitlines() if line.startswith("IMPORTED")]
    assert len(imported_names) == len(lines), run.stderr
    return imported_names


@pytest.fixture
def link() -> Iterator[str]:
    channel = UdpChannel(parse_address("udpin:127.0.0.1:0"))
    server = Server(channel, Station(Mock(Autopilot.PX4, Geodetic(47.397742, 8.545594, 488.0))), 60.0, Faults(), 0)
    stop = threading.Event()
    thread = threading.Thread(target=server.run, args=(stop.is_set,))
    thread.start()
    yield f"udpout:127.0.0.1:{port_of(channel)}"
    stop.set()
    thread.join()
    channel.close()


def test_cli_help_and_mission_files_import_no_large_libraries() -> None:
    helped, *looked = imported("--help", *(f"{verb} {FOR_ARDUPILOT}" for verb in ("show", "check", "estimate")))
    assert helped == set()
    assert looked == [{"numpy", "pyproj"}] * 3


def test_options_are_converted_as_by_typer(tmp_path: Path) -> None:
    unreadable = tmp_path / "unreadable.plan"
    unreadable.touch(mode=0)
    texts = ("", "7", "7.5", "-1", "px4", "mavsdk", "yes", "missing.toml", str(tmp_path), str(unreadable))
    for verb in command().commands.values():
        ctx = typer.Context(verb)
        for option in verb.params:
            converted = option.get_runtime_param()
            (by_typer,) = converted.coerce.args
            for text in (None, option.default, *texts):
                is_many = isinstance(text, str) and (option.multiple or option.nargs == -1)
                value = (text, text) if is_many else text
                assert coerced(converted, value, option, ctx) == coerced(by_typer(), value, option, ctx)


def coerced(runtime: Any, value: object, option: object, ctx: object) -> object:
    """Return the value and its type, or the error."""
    try:
        value = runtime.coerce(value, param=option, ctx=ctx)
    except Exception as error:
        return str(error)
    return value, type(value)


def test_cli_upload_imports_only_the_messages_besides(link: str, tmp_path: Path) -> None:
    log = str(tmp_path / "upload.tlog")
    hurried = "from tests.quick_link import hurry; hurry()"
    (needed,) = imported(f"upload {FOR_PX4} --link {link} --log {log}", before=hurried)
    assert needed - {"pymavlink"} == {"numpy", "pyproj"}  # in a checkout


ENDING = """
import atexit, gc, sys
atexit.register(lambda: print(gc.get_freeze_count(), len(gc.get_objects())))
from ipoa_mission.__main__ import main
sys.argv = ["ipoa-mission", "--version"]
main()
"""


def test_the_last_collections_visit_few_objects() -> None:
    """They take 0.05 s of CPU of each verb otherwise."""
    ended = subprocess.run([sys.executable, "-c", ENDING], capture_output=True, text=True, timeout=300)
    frozen, visited = map(int, ended.stdout.splitlines()[-1].split())
    assert visited < 1000 < 10_000 < frozen
