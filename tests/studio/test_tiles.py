import pytest

from ipoa_mission.studio.web_server import POLICY, policy_for, tiles_at
from tests.refused import refuses

SERVER = "https://tiles.example:8443/{z}/{x}/{y}.png"


def test_a_server_is_asked_by_the_page_and_let_in_alone() -> None:
    tiles = tiles_at(SERVER, "The Town")
    assert (tiles.address, tiles.attribution) == (SERVER, "The Town")
    assert tiles_at(SERVER).attribution == "tiles.example:8443"
    wider = policy_for(tiles)
    assert wider.replace(" https://tiles.example:8443", "") == POLICY
    assert wider.count("https://tiles.example:8443") == 2
    assert policy_for(None) == POLICY


def test_wmts_templates_are_understood() -> None:
    tiles = tiles_at("http://127.0.0.1/wmts/{TileMatrix}/{TileRow}/{TileCol}.jpg")
    assert tiles.address == "http://127.0.0.1/wmts/{z}/{y}/{x}.jpg"


def test_vector_tiles_are_recognized_by_their_suffix() -> None:
    assert tiles_at("https://tiles.example/{z}/{x}/{y}.pbf?key=1").vector
    assert not tiles_at(SERVER).vector


@pytest.mark.parametrize(
    "address",
    [
        "https://tiles.example/{z}/{x}.png",
        "ftp://tiles.example/{z}/{x}/{y}",
        "https://a b/{z}/{x}/{y}",
        "https://x; script-src */{z}/{x}/{y}",
        "https://user:word@tiles.example/{z}/{x}/{y}",
        "town.mbtiles",
        "town.pmtiles",
    ],
)
def test_wrong_sources_of_tiles_are_refused(address: str) -> None:
    with refuses("bad-input", f"--tiles: {address}"):
        tiles_at(address)
