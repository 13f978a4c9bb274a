import sys
from pathlib import Path

import pytest

from tests.cli.conftest import Run

SCENARIO = """
home = { latitude_deg = 47.0, longitude_deg = 8.0 }
start = { east = 0, north = 0, up = 15 }
goal = { east = 60, north = 0, up = 15 }
maps = [{ kind = "KIND", file = "FILE" }]
"""
RING = [(8.0003, 46.9999), (8.0005, 46.9999), (8.0005, 47.0001), (8.0003, 47.0001), (8.0003, 46.9999)]


def extract(path: Path) -> None:
    osmium = pytest.importorskip("osmium")
    with osmium.SimpleWriter(path) as writer:
        for number, place in enumerate(RING[:4], 1):
            writer.add_node(osmium.osm.mutable.Node(id=number, location=place))
        tags = {"building": "yes", "height": "20"}
        writer.add_way(osmium.osm.mutable.Way(id=9, nodes=[1, 2, 3, 4, 1], tags=tags))


@pytest.mark.alone
def test_a_building_of_it_is_flown_round(run: Run) -> None:
    file = "town.osm.pbf"
    extract(Path(file))
    Path("town.toml").write_text(SCENARIO.replace("KIND", "buildings").replace("FILE", file))
    ended = run("plan town.toml --json")
    assert ended.code == 0, ended.err
    assert "way/9" in ended.out  # what it comes nearest to


@pytest.mark.alone
def test_a_scenario_is_begun_from_it_and_an_area_of_it_is_surveyed(run: Run) -> None:
    file = "town.osm.pbf"
    extract(Path(file))
    begun = run(f"new town.toml --buildings {file}")
    assert begun.code == 0, begun.err
    assert file in Path("town.toml").read_text()
    surveyed = run(f"plan --survey {file} --json")
    assert surveyed.code == 0, surveyed.err


@pytest.mark.parametrize(("file", "library"), [("town.gpkg", "pyarrow"), ("town.osm.pbf", "osmium")])
@pytest.mark.parametrize("words", ["plan town.toml", "plan --survey FILE", "new begun.toml --buildings FILE"])
def test_missing_library_leaves_nothing_written(
    run: Run, monkeypatch: pytest.MonkeyPatch, file: str, library: str, words: str
) -> None:
    Path(file).write_bytes(b"SQLite format 3\x00")
    Path("town.toml").write_text(SCENARIO.replace("KIND", "no_fly").replace("FILE", file))
    before = sorted(Path().iterdir())
    for name in [name for name in sys.modules if name.partition(".")[0] == library]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, library, None)
    ended = run(words.replace("FILE", file))
    assert ended.code == 2
    assert f"{file}: reading it needs {library}, which is not installed" in ended.err
    assert "pip install 'ipoa-mission[maps]'" in ended.err
    assert sorted(Path().iterdir()) == before
