"""The page in Chromium by playwright; skipped without. IPOA_MISSION_CHROMIUM may name the browser."""

import os
import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from ipoa_mission.flight.flight import write_report
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.simulator.fly import fly_built_in
from tests.examples import some
from tests.report.conftest import Bowed, Planned

BROWSERS = (os.environ.get("IPOA_MISSION_CHROMIUM", ""), "chromium", "chromium-browser", "google-chrome")
CHROMIUM = next((path for name in BROWSERS if name and (path := shutil.which(name))), None)
pytestmark = pytest.mark.skipif(
    CHROMIUM is None or find_spec("playwright") is None, reason="needs Chromium and playwright"
)


@dataclass(frozen=True)
class Tab:
    """A tab, and its complaints and requests."""

    page: Any
    complaints: list[str]

    def visit(self, file: Path, width: int = 1280, scheme: str = "light") -> Any:
        self.page.set_viewport_size({"width": width, "height": 900})
        self.page.emulate_media(color_scheme=scheme)
        self.page.mouse.move(0, 0)
        self.page.goto(file.as_uri())
        self.page.wait_for_function("document.getElementById('map').dataset.zoom !== undefined")
        return self.page


@pytest.fixture(scope="module")
def only_tab() -> Iterator[Tab]:
    """Open one tab for all tests: another is another process."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as play:
        chromium = play.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        tab = Tab(chromium.new_page(), [])
        hear = tab.complaints.append
        tab.page.on("console", lambda message: hear(message.text))
        tab.page.on("pageerror", lambda error: hear(str(error)))
        tab.page.on("request", lambda request: None if request.url.startswith("file:") else hear(request.url))
        yield tab
        chromium.close()


@pytest.fixture
def tab(only_tab: Tab) -> Iterator[Tab]:
    """Expect no complaint and no request."""
    only_tab.complaints.clear()
    yield only_tab
    assert only_tab.complaints == []


@pytest.fixture(scope="module")
def report(planned: Planned, tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    folder = tmp_path_factory.mktemp("reports")

    @cache
    def written(name: str) -> Path:
        forecast, plan = planned(name)
        write_report(forecast, folder / f"{name}.html", plan)
        return folder / f"{name}.html"

    return written


@pytest.fixture
def open_page(tab: Tab, report: Callable[[str], Path]) -> Callable[..., Any]:
    def visit(name: str = "campus.toml", width: int = 1280, scheme: str = "light") -> Any:
        return tab.visit(report(name), width, scheme)

    return visit


def shown(page: Any, selector: str) -> str:
    return str(page.locator(selector).inner_text())


@pytest.mark.parametrize("name", some(1, ["campus.toml", "downtown.toml", "sitl.toml"]))
def test_every_view_is_drawn(open_page: Callable[..., Any], name: str) -> None:
    page = open_page(name)
    for selector in (".map svg", "#profile svg", "#apart svg", "#speed svg", "#legs"):
        box = page.locator(selector).bounding_box()
        assert box["width"] > 300
        assert box["height"] > 60


@pytest.mark.parametrize(
    "selector", ["#map button.stop", "#profile button.stop", "tr[data-stop]", "#speed button.mark"]
)
def test_choosing_an_item_anywhere_marks_it_everywhere(open_page: Callable[..., Any], selector: str) -> None:
    page = open_page()
    page.locator(f'{selector}[data-stop="5"]').click()
    chosen = page.locator(".chosen").evaluate_all("all => all.map((one) => one.closest('[id]').id)")
    assert sorted(set(chosen)) == ["legs", "map", "profile", "speed"]
    assert "item 6" in shown(page, ".readout")
    page.keyboard.press("Escape")
    assert page.locator(".chosen").count() == 0


def test_pointing_at_the_profile_moves_the_mark_on_the_map(open_page: Callable[..., Any]) -> None:
    page = open_page()
    plot = page.locator("#profile .plot")
    plot.scroll_into_view_if_needed()
    box = plot.bounding_box()
    places = []
    for share in (0.2, 0.8):
        page.mouse.move(box["x"] + share * box["width"], box["y"] + 0.5 * box["height"])
        places.append(page.evaluate("parseFloat(document.querySelector('.here').style.left)"))
        cursors = page.locator(".cursor").evaluate_all("all => all.map((one) => parseFloat(one.style.left))")
        assert cursors[0] == pytest.approx(100 * share, abs=1.0)
    assert places[1] > places[0] + 20  # the flight goes east
    assert "above home" in shown(page, ".readout")


def test_pointing_at_a_moment_draws_the_way_home_from_there(open_page: Callable[..., Any]) -> None:
    page = open_page("sitl.toml")
    drawn = "document.querySelector('path.way-home').getAttribute('d')"
    assert page.evaluate(drawn) == ""
    plot = page.locator("#profile .plot")
    plot.scroll_into_view_if_needed()
    box = plot.bounding_box()
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    here = page.evaluate("parseFloat(document.querySelector('.here').style.left)")
    points = [tuple(map(float, pair.split())) for pair in page.evaluate(drawn)[1:].split("L")]
    assert len(points) == 6
    assert points[-1] == pytest.approx((0.0, 0.0), abs=0.5)  # home
    view = page.evaluate("({...document.getElementById('map').dataset})")
    left = 100 * (points[0][0] - float(view["west"])) / float(view["width"])
    assert left == pytest.approx(here, abs=8.0)  # within a second of it
    page.keyboard.press("Escape")
    assert page.evaluate(drawn) == ""


def test_the_map_zooms_by_buttons_wheel_and_fingers_and_keeps_its_markers(open_page: Callable[..., Any]) -> None:
    page = open_page()
    plan = page.locator("#map")
    plan.scroll_into_view_if_needed()
    box = plan.bounding_box()
    zoom = lambda: float(plan.get_attribute("data-zoom"))  # noqa: E731
    stop = page.locator('#map [data-stop="4"]')
    spot = lambda: _within(plan.bounding_box(), stop.bounding_box())  # noqa: E731
    length = lambda: shown(page, ".scale")  # noqa: E731
    first, whole = spot(), length()

    page.mouse.move(box["x"] + first[0], box["y"] + first[1])
    page.mouse.wheel(0, -2000)
    page.wait_for_function("scrollY === 0")
    assert zoom() == 1.0  # the page scrolls until the map is taken
    plan.scroll_into_view_if_needed()
    stop.click()
    page.mouse.wheel(0, -600)
    page.wait_for_function("Number(document.getElementById('map').dataset.zoom) > 2")
    assert spot() == pytest.approx(first, abs=1.5)  # what one points at stays where it is
    assert length() != whole

    box = plan.bounding_box()
    page.mouse.move(box["x"] + 60, box["y"] + 200)
    page.mouse.down()
    page.mouse.move(box["x"] + 90, box["y"] + 180, steps=4)
    page.mouse.up()
    assert spot() == pytest.approx((first[0] + 30, first[1] - 20), abs=1.5)
    stop.click()
    assert page.evaluate(HERE_IS_ON_ITS_STOP)

    page.locator('tr[data-stop="0"]').click()  # outside of what the map shows
    there = _within(plan.bounding_box(), page.locator('#map [data-stop="0"]').bounding_box())
    assert 0 <= there[0] <= box["width"]
    assert 0 <= there[1] <= box["height"]

    page.locator('#map [data-key="Home"]').click()
    assert (zoom(), length()) == (1.0, whole)
    assert spot() == pytest.approx(first, abs=1.5)
    page.locator('#map [data-key="+"]').click()
    assert zoom() == 1.5
    plan.focus()
    page.keyboard.press("0")
    box = plan.bounding_box()
    page.evaluate(PINCH, [box["x"] + 200, box["y"] + 150])
    assert zoom() == pytest.approx(3.0, rel=0.05)


#: The mark is on the clicked button.
HERE_IS_ON_ITS_STOP = """() => {
  const middle = (e) => { const b = e.getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]; };
  const [a, b] = [middle(document.querySelector("#map .here")), middle(document.querySelector("#map .chosen"))];
  return Math.hypot(a[0] - b[0], a[1] - b[1]) < 12;
}"""
#: Two fingers 40, then 120 pixels apart.
PINCH = """([x, y]) => {
  const map = document.getElementById("map");
  const send = (kind, id, dx) => map.dispatchEvent(new PointerEvent(kind,
    { pointerId: id, pointerType: "touch", clientX: x + dx, clientY: y, bubbles: true }));
  send("pointerdown", 1, -20); send("pointerdown", 2, 20);
  for (const half of [30, 45, 60]) { send("pointermove", 1, -half); send("pointermove", 2, half); }
  send("pointerup", 1, -60); send("pointerup", 2, 60);
}"""


def _within(box: dict[str, float], part: dict[str, float]) -> tuple[float, float]:
    """Return the middle of a part, from the corner of the whole [pixels]."""
    return part["x"] + part["width"] / 2 - box["x"], part["y"] + part["height"] / 2 - box["y"]


@pytest.mark.parametrize("width", [390, 768, 1280])
def test_page_is_not_wider_than_the_screen(open_page: Callable[..., Any], width: int) -> None:
    page = open_page(width=width)
    assert page.evaluate("document.documentElement.scrollWidth") == width
    small = page.evaluate(
        """() => [...document.querySelectorAll('body *')]
        .filter((e) => e.childElementCount === 0 && e.textContent.trim() && e.getClientRects().length)
        .filter((e) => parseFloat(getComputedStyle(e).fontSize) < 10.9).map((e) => e.textContent)"""
    )
    assert small == []


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_words_and_lines_stand_out_from_what_they_are_on(open_page: Callable[..., Any], scheme: str) -> None:
    page = open_page(scheme=scheme)
    for text, paper in (("--ink", "--card"), ("--quiet", "--card"), ("--good", "--paper"), ("--bad", "--paper")):
        assert contrast(page, text, paper) > 4.5  # WCAG 2.2, 1.4.3
    for line in ("--planned", "--flown"):
        assert contrast(page, line, "--card") > 3.0  # 1.4.11


def contrast(page: Any, foreground: str, background: str) -> float:
    """WCAG's definition."""
    colors = page.evaluate(
        """(names) => names.map((name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim())""",
        [foreground, background],
    )
    return _contrast(*(_luminance(color) for color in colors))


def _luminance(color: str) -> float:
    digits = color.lstrip("#")
    digits = "".join(2 * d for d in digits) if len(digits) == 3 else digits
    channels = [int(digits[k : k + 2], 16) / 255 for k in (0, 2, 4)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
    return sum(weight * c for weight, c in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


def _contrast(luminance: float, other_luminance: float) -> float:
    low, high = sorted((luminance, other_luminance))
    return (high + 0.05) / (low + 0.05)


def test_report_prints_on_a_few_pages(open_page: Callable[..., Any]) -> None:
    page = open_page()
    paper = page.pdf(format="A4")
    assert paper.startswith(b"%PDF")
    assert 1 <= paper.count(b"/Type /Page\n") <= 4


def test_both_paths_and_times_are_shown_after_a_flight(tab: Tab, bowed: Bowed, tmp_path: Path) -> None:
    scenario, mission, _ = bowed("sitl.toml")
    file = tmp_path / "flown.html"
    write_report(Forecast(mission, scenario), file, None, fly_built_in(mission))
    page = tab.visit(file, width=390)
    assert page.locator("path.flown").count() == 3  # map, height profile, speed
    for text in ("flown", "the estimate is off by", "off by"):
        assert page.get_by_text(text).first.is_visible()
    assert page.evaluate("document.documentElement.scrollWidth") == 390
