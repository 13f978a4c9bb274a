"""Needs Firefox and the built page, and Xvfb for the map; skipped without."""

import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from ipoa_mission.errors import MissionError
from tests.studio.conftest import MEADOW
from tests.studio.firefox import Firefox, firefox
from tests.studio.pointing import middle_of, settled

pytest.importorskip("websockets")
FIREFOX = next((path for name in ("firefox-esr", "firefox") if (path := shutil.which(name))), None)
XVFB = shutil.which("Xvfb")
pytestmark = [pytest.mark.skipif(FIREFOX is None, reason="needs Firefox"), pytest.mark.long]
TEXT = "document.querySelector('textarea').value"
PROVED = "document.querySelector('.verdict .good, .verdict .amber') !== null"


def button(name: str) -> str:
    return f"[...document.querySelectorAll('button')].find(one => (one.ariaLabel ?? one.textContent) === {name!r})"


def field(label: str) -> str:
    labels = "[...document.querySelectorAll('label')]"
    return f"{labels}.find(one => one.textContent.includes({label!r})).querySelector('input')"


@pytest.fixture
def address(tmp_path: Path) -> Iterator[tuple[str, Path]]:
    from ipoa_mission.studio.bundle import built_page

    try:
        built_page(print)
    except MissionError as error:
        pytest.skip(str(error))
    scenario = Path(shutil.copy(MEADOW, tmp_path / "meadow.toml"))
    command = [sys.executable, "-m", "tests.studio.quick_studio", "studio", str(scenario), "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=Path(__file__).parents[2]) as studio:
        assert studio.stdout is not None
        match = re.search(r"http://\S+", studio.stdout.readline())
        assert match is not None
        yield match[0], scenario
        studio.terminate()


def fly(page: Firefox) -> None:
    page.click("[...document.querySelectorAll('summary')].find(one => one.textContent === 'Fly it')")
    page.until(f"{button('Upload')} !== undefined")
    page.click(field("Speed-up"))
    page.value(f"{field('Speed-up')}.select()")
    page.type("20\ue004")  # and Tab
    page.click(button("Upload"))
    page.until(f"{button('Arm and start …')} !== undefined")
    page.click(button("Arm and start …"))
    page.until("document.querySelector('dialog[open]') !== null")
    page.click("document.querySelector('dialog input')")
    page.type("meadow")
    page.until("!document.querySelector('dialog .danger').disabled")
    page.click("document.querySelector('dialog .danger')")
    page.until("document.body.innerText.includes('✓ Landed')")


@pytest.mark.skipif(XVFB is None, reason="needs Xvfb: WebGL wants a screen")
def test_firefox_drags_the_goal_draws_a_building_saves_and_flies(address: tuple[str, Path], tmp_path: Path) -> None:
    assert FIREFOX is not None
    (tmp_path / "profile").mkdir()
    with firefox(FIREFOX, tmp_path / "profile", XVFB) as page:
        page.open(address[0])
        (sx, sy), (gx, gy) = (settled(page.value, middle_of(f"[data-spot={name}]")) for name in ("start", "goal"))
        page.drag((gx, gy), (gx - 10, gy - 15), (gx - 20, gy - 30))
        page.until(f"!{TEXT}.includes('east = 60.0')")
        page.click(button("Undo"))
        page.until(f"{TEXT}.includes('east = 60.0')")
        settled(page.value)
        page.click(button("Building, corner by corner"))
        for east, north in ((0.2, 0.3), (0.3, 0.3), (0.3, 0.4), (0.2, 0.4), (0.2, 0.3)):
            page.drag((sx + east * (gx - sx), sy - north * (gx - sx)))
        page.until(f"{TEXT}.split('[[obstacles]]').length === 4")
        page.until(PROVED)
        page.click(button("3-D"))
        page.until("map.getPitch() > 50")
        page.click(button("Save"))
        page.until("document.querySelector('.saved') !== null")
        fly(page)
        assert [words for words in page.complaints if "WebGL" not in words] == []
        assert [url for url in page.asked if not url.startswith(("blob:", "data:", address[0][:18]))] == []
    assert address[1].read_text().count("[[obstacles]]") == 3


def test_page_without_webgl_works_but_for_the_map(address: tuple[str, Path], tmp_path: Path) -> None:
    assert FIREFOX is not None
    (tmp_path / "profile").mkdir()
    with firefox(FIREFOX, tmp_path / "profile", None) as page:
        page.open(address[0])
        page.until("document.body.innerText.includes('No map is drawn')")
        page.until(PROVED)
        fly(page)
