import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from tests.cli.conftest import Run
from tests.sources import copy_sources

IN_THE_END = re.compile(r"estimated (\d+\.\d) s, flown (\d+\.\d) s; 99 % of flights keep (\d\.\d\d) m")


def test_a_packed_scenario_is_planned_by_its_name_unless_a_file_has_it(run: Run, tmp_path: Path) -> None:
    wrong = run("plan downtown")
    assert (wrong.code, wrong.out) == (2, "")
    (tmp_path / "campus").write_text("safety_distance = -1.0\n", encoding="utf-8")
    ended = run("plan campus")
    assert ended.code == 2
    assert "campus: safety_distance" in ended.err


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Install a read-only wheel of these sources, without the studio's page."""
    folder = tmp_path_factory.mktemp("wheel")
    sources = copy_sources(folder / "sources")
    build = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-build-isolation", "--no-deps", "-w", str(folder)]
    subprocess.run([*build, str(sources)], check=True, timeout=500, env=os.environ | {"IPOA_MISSION_NO_PAGE": "1"})
    (wheel,) = folder.glob("*.whl")
    site = folder / "site"
    with zipfile.ZipFile(wheel) as packed:
        packed.extractall(site)
    for path in (site, *site.rglob("*")):
        path.chmod(0o555 if path.is_dir() else 0o444)
    return site


@pytest.mark.long
def test_the_demo_of_a_read_only_wheel_flies_and_compiles_nothing(installed: Path, tmp_path: Path) -> None:
    """numba is out of reach."""
    hidden = "import sys; sys.modules['numba'] = None"
    lines = f"{hidden}; from ipoa_mission.cli.app import main; main()"
    env = {
        **{name: value for name, value in os.environ.items() if not name.startswith(("NUMBA", "IPOA", "XDG"))},
        "PYTHONPATH": str(installed), "HOME": "/nonexistent", "COLUMNS": "80", "PYTHONDONTWRITEBYTECODE": "1",
    }  # fmt: skip
    command = [sys.executable, "-P", "-c", lines, "demo"]
    run = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, env=env, timeout=300)
    assert run.returncode == 0, run.stderr
    ended = IN_THE_END.search(run.stdout)
    assert ended, run.stdout
    estimated, flown, kept = map(float, ended.groups())
    assert abs(estimated - flown) < 1.0
    assert kept > 2.6  # what the scenario requires
    names = {path.name for path in (tmp_path / "demo").iterdir()}
    assert names == {"campus.plan", "campus.params", "campus.waypoints", "campus.json", "campus.tlog", "campus.html"}
    assert max(map(len, run.stdout.splitlines())) <= 120


def test_a_reader_that_goes_away_is_no_traceback() -> None:
    command = f"{shutil.which(sys.executable)} -m ipoa_mission schema | head -1"
    run = subprocess.run(["bash", "-c", command], capture_output=True, text=True, timeout=300)
    assert run.stdout == "{\n"
    assert "Traceback" not in run.stderr
