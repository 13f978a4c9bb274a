import gzip
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from ipoa_mission.studio import tiles
from ipoa_mission.studio.session import Session
from ipoa_mission.studio.sessions import Sessions
from ipoa_mission.studio.web_server import POLICY, application, policy_for
from tests.refused import refuses
from tests.studio.conftest import HOST, MEADOW, TOKEN, testclient

PICTURE = b"\x89PNG\r\n\x1a\n and so on"
SERVER = "https://tiles.example:8443/{z}/{x}/{y}.png"


def mbtiles(path: Path, kind: str = "png", count: int = 1, layers: str = "", tile: bytes = PICTURE) -> Path:
    with closing(sqlite3.connect(path)) as file:
        file.execute("create table metadata (name text, value text)")
        file.execute("create table tiles (zoom_level int, tile_column int, tile_row int, tile_data blob)")
        about = {"format": kind, "attribution": '<a href="https://x.example">&copy; The Town</a>'}
        about |= {"json": layers} if layers else {}
        file.executemany("insert into metadata values (?, ?)", about.items())
        file.executemany("insert into tiles values (3, 4, 5, ?)", [(tile,)] * count)
        file.commit()
    return path


def test_a_server_is_asked_by_the_page_and_let_in_alone() -> None:
    opened = tiles.open_tiles(SERVER, "The Town")
    assert opened.shown.address == SERVER
    assert opened.shown.attribution == "The Town"
    assert opened.read is None
    wider = policy_for(opened.origin)
    assert wider.replace(" https://tiles.example:8443", "") == POLICY
    assert wider.count("https://tiles.example:8443") == 2
    assert policy_for(None) == POLICY


def test_wmts_templates_are_understood() -> None:
    opened = tiles.open_tiles("http://127.0.0.1/wmts/{TileMatrix}/{TileRow}/{TileCol}.jpg")
    assert opened.shown.address == "http://127.0.0.1/wmts/{z}/{y}/{x}.jpg"


@pytest.mark.parametrize(
    "address",
    [
        "https://tiles.example/{z}/{x}.png",
        "ftp://tiles.example/{z}/{x}/{y}",
        "https://a b/{z}/{x}/{y}",
        "https://x; script-src */{z}/{x}/{y}",
        "https://user:word@tiles.example/{z}/{x}/{y}",
        "nothing.mbtiles",
        "tiles.zip",
        "town.pmtiles",
    ],
)
def test_wrong_sources_of_tiles_are_refused(address: str) -> None:
    with refuses("bad-input"):
        tiles.open_tiles(address)


def test_a_file_is_read_from_the_north_and_says_whose_it_is(tmp_path: Path) -> None:
    opened = tiles.open_tiles(str(mbtiles(tmp_path / "a.mbtiles")))
    assert opened.origin is None
    assert (opened.shown.min_zoom, opened.shown.max_zoom) == (3, 3)
    assert opened.shown.attribution == "© The Town"
    assert opened.read is not None
    assert opened.read(3, 4, 2) == PICTURE  # rows of MBTiles count from the south
    assert opened.read(3, 4, 5) is None


@pytest.mark.parametrize(
    ("kind", "count", "why"), [("svg", 1, ("wrong-format", "a.mbtiles")), ("png", 0, ("nothing-there", "a.mbtiles"))]
)
def test_a_file_without_pictures_is_refused(tmp_path: Path, kind: str, count: int, why: tuple[str, ...]) -> None:
    with refuses(*why):
        tiles.open_tiles(str(mbtiles(tmp_path / "a.mbtiles", kind, count)))


def test_a_file_that_is_something_else_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.mbtiles").write_bytes(b"no such thing" * 100)
    with refuses("wrong-format"):
        tiles.open_tiles(str(tmp_path / "a.mbtiles"))


def test_vector_tiles_are_recognized_by_format_and_served_compressed(tmp_path: Path) -> None:
    layers = '{"vector_layers": [{"id": "water"}, {"id": "roads"}, 7]}'
    packed = gzip.compress(b"a tile")
    file = tiles.open_tiles(str(mbtiles(tmp_path / "a.mbtiles", "pbf", layers=layers, tile=packed)))
    assert (file.shown.vector, file.shown.layers) == (True, ("water", "roads"))
    sessions = Sessions()
    sessions.hosts[TOKEN] = Session(MEADOW)
    client = testclient.TestClient(application(sessions, tmp_path, HOST, file), base_url=f"http://{HOST}")
    answer = client.get(f"/{TOKEN}/tiles/3/4/2")
    assert (answer.headers["content-encoding"], answer.content) == ("gzip", b"a tile")
    assert tiles.headers_of(b"a tile", vector=True) == {"Content-Type": "application/vnd.mapbox-vector-tile"}
    served = tiles.open_tiles("https://tiles.example/{z}/{x}/{y}.pbf?key=1")
    assert (served.shown.vector, served.shown.layers) == (True, ())
    assert not tiles.open_tiles(SERVER).shown.vector
    odd = tiles.open_tiles(str(mbtiles(tmp_path / "b.mbtiles", "pbf", layers="{")))
    assert odd.shown.layers == ()


def test_the_page_gets_tiles_of_the_file_and_nothing_more(tmp_path: Path) -> None:
    source = tiles.open_tiles(str(mbtiles(tmp_path / "a.mbtiles")))
    sessions = Sessions()
    sessions.hosts[TOKEN] = Session(MEADOW)
    client = testclient.TestClient(application(sessions, tmp_path, HOST, source), base_url=f"http://{HOST}")
    answer = client.get(f"/{TOKEN}/tiles/3/4/2")
    assert (answer.content, answer.headers["content-type"]) == (PICTURE, "image/png")
    assert client.get(f"/{TOKEN}/tiles/3/4/3").status_code == 204
    assert client.get(f"/{TOKEN}/tiles/99/0/0").status_code == 404
    assert client.get("/tiles/3/4/2").status_code == 403
