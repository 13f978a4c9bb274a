"""The page in Chromium by playwright, with the built page (or npm); skipped without."""

import json
import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from urllib.parse import urljoin

import pytest

from ipoa_mission.errors import MissionError
from ipoa_mission.files import write_atomically
from tests.studio.conftest import MEADOW
from tests.studio.pointing import PATIENCE_S, Hand, middle_of, settled

BROWSERS = (os.environ.get("IPOA_MISSION_CHROMIUM", ""), "chromium", "chromium-browser", "google-chrome")
CHROMIUM = next((path for name in BROWSERS if name and (path := shutil.which(name))), None)
in_a_browser = pytest.mark.skipif(
    CHROMIUM is None or find_spec("playwright") is None, reason="needs Chromium and playwright"
)
pytestmark = [in_a_browser, pytest.mark.long]  # the short tests of the browser are in test_stays

REPOSITORY = Path(__file__).parents[2]
WEB = REPOSITORY / "ipoa_mission" / "studio" / "web"
#: Draw only the map by a GPU, coarsely.
SOFTWARE = [
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-gpu-compositing",
    "--webgl-antialiasing-mode=none",
]
COARSE = 0.5  # of picture pixels to page pixels
#: The browser's words about this setup.
OF_THE_SETUP = "GL Driver Message (OpenGL, Performance, GL_CLOSE_PATH_NV, High): GPU stall due to ReadPixels"
PATIENCE_MS = int(1000 * PATIENCE_S)
USUAL = {"width": 1280, "height": 800}


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[str, Path]]:
    from ipoa_mission.studio.bundle import built_page

    try:
        built_page(print)
    except MissionError as error:
        pytest.skip(str(error))
    scenario = Path(shutil.copy(MEADOW, tmp_path_factory.mktemp("page") / "meadow.toml"))
    command = [sys.executable, "-m", "tests.studio.quick_studio", "studio", str(scenario), "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=REPOSITORY) as studio:
        assert studio.stdout is not None
        match = re.search(r"http://\S+", studio.stdout.readline())
        assert match is not None
        yield match[0], scenario
        studio.terminate()


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    from playwright.sync_api import sync_playwright

    with sync_playwright() as play:
        chromium = play.chromium.launch(executable_path=CHROMIUM, args=SOFTWARE)
        yield chromium
        chromium.close()


class Window:
    """A page on the studio, and what was complained of in it."""

    def __init__(self, browser: Any, url: str) -> None:
        self.complaints: list[str] = []
        self.page = browser.new_page(viewport=USUAL, reduced_motion="reduce", device_scale_factor=COARSE)
        self.page.set_default_timeout(PATIENCE_MS)
        self.page.on("console", self._hear)
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("request", lambda asked: self.complaints.extend([asked.url] * is_elsewhere(asked.url, url)))
        self.page.goto(url)
        until(self.page, "window.map?.isStyleLoaded()")

    def _hear(self, message: Any) -> None:
        if OF_THE_SETUP not in message.text:
            self.complaints.append(f"{message.type}: {message.text}")

    @contextmanager
    def on_the_meadow(self, scenario: Path) -> Iterator[Any]:
        """Open the page on the repository's scenario; expect no complaints."""
        if self.page.locator("textarea").input_value() != MEADOW.read_text():
            rewrite(self.page, MEADOW.read_text())
        yield self.page
        write_atomically(scenario, MEADOW.read_text())  # the studio never sees half of it
        assert not self.complaints, self.complaints


def is_elsewhere(asked: str, url: str) -> bool:
    """Return whether anyone but the page's server is asked."""
    return not asked.startswith((urljoin(url, "/"), "blob:", "data:"))


@pytest.fixture
def own_page(browser: Any, address: tuple[str, Path]) -> Iterator[Any]:
    """Open a page for one test."""
    window = Window(browser, address[0])
    with window.on_the_meadow(address[1]) as page:
        yield page
        page.close()


@pytest.fixture(scope="module")
def window(browser: Any, address: tuple[str, Path]) -> Window:
    """Keep a page for many tests: the map takes seconds to begin."""
    return Window(browser, address[0])


@pytest.fixture
def page(window: Window, address: tuple[str, Path]) -> Iterator[Any]:
    window.page.set_viewport_size(USUAL)
    window.page.emulate_media(media="screen", color_scheme="light", reduced_motion="reduce")
    with window.on_the_meadow(address[1]) as page:
        yield page


def came_true(page: Any, expression: str, patience_s: float) -> bool:
    """Wait for an expression; playwright's own wait uses `eval`, which the page forbids."""
    until_s = time.monotonic() + patience_s
    while time.monotonic() < until_s:
        if page.evaluate(expression):
            return True
        page.wait_for_timeout(25)
    return False


def until(page: Any, expression: str) -> None:
    assert came_true(page, expression, PATIENCE_S), f"never came true: {expression}"


def rewrite(page: Any, text: str) -> None:
    """Change the scenario's text; again where the program has just read an earlier one."""
    page.locator("summary", has_text="The scenario's text").click()
    for _ in range(6):
        page.locator("textarea").fill(text)
        page.get_by_role("button", name="Apply").click()
        page.locator("button:disabled", has_text="Apply").wait_for()  # what is shown is what the program has
        if came_true(page, f"document.querySelector('textarea').value === {json.dumps(text)}", PATIENCE_S / 6):
            break
    assert scenario_of(page) == text
    page.locator("summary", has_text="The scenario's text").click()


def proved(page: Any) -> None:
    """Wait for a plan of the present text."""
    settled(page.evaluate, "document.querySelector('.verdict :is(.good, .amber)') && true")


def scenario_of(page: Any) -> str:
    return str(page.locator("textarea").input_value())


def places(page: Any, *shares: tuple[float, float]) -> list[tuple[float, float]]:
    """Return screen places: shares of the way from start to goal, and aside."""
    (x, y), (goal, _) = (Hand(page).at(middle_of(f"[data-spot={name}]")) for name in ("start", "goal"))
    return [(x + east * (goal - x), y - north * (goal - x)) for east, north in shares]


def serious(page: Any, scheme: str) -> list[str]:
    """Return axe's serious findings, with every panel open."""
    axe = WEB / "node_modules" / "axe-core" / "axe.min.js"
    if not axe.is_file():
        pytest.skip("needs axe-core: npm ci in ipoa_mission/studio/web")
    page.emulate_media(color_scheme=scheme)
    page.evaluate("document.querySelectorAll('details').forEach(panel => { panel.open = true; })")
    page.evaluate(axe.read_text(encoding="utf-8"))
    wrong = page.evaluate("axe.run().then(found => found.violations)")
    grave = [error for error in wrong if error["impact"] in ("serious", "critical")]
    return [f"{violation['id']}: {node['target']}" for violation in grave for node in violation["nodes"]]
