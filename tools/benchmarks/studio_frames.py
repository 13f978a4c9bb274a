"""How smoothly the studio's map is drawn while a hand drags, in Chromium, which draws by software.

    python -m tools.benchmarks.studio_frames [--buildings 500 5000] [--width 1440] [--height 900] [--what pan zoom ...]

Chromium's own pointer drags over a town: the map, a building that the scenario draws, a via point, the goal; it zooms,
and turns the map in space. Told are for each the frames, and what a frame costs: the page's script, and all that the
page's main thread does, as Chromium's trace has them in processor time of that thread, which does not depend on what
else the machine does ([ms]: median, 95th percentile, worst); the processor time that drawing takes of all cores
([ms a frame]), of which a graphics card would relieve them; and frames a second as they came, which depend on all of
it. Last stands the longest that the main thread is kept by one task after the hand has let go [ms].
"""

import shutil
import statistics
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, Page, sync_playwright
from rich.console import Console
from rich.table import Table

from tools import command_line
from tools.benchmarks.studio import town
from tools.generate.studio_pictures import PATIENCE_MS, SOFTWARE, studio

OWN = """[[via]]
east = 2.0
north = 40.0
up = 18.0
[[obstacles]]
kind = "box"
name = "own"
east = 40.0
north = -12.0
width = 14.0
depth = 14.0
height = 12.0
"""
SCRIPT = {"FunctionCall", "EvaluateScript", "FireAnimationFrame", "TimerFire", "EventDispatch"}
FRAME, TASK = "ProxyMain::BeginMainFrame", "ThreadControllerImpl::RunTask"
CATEGORIES = ["toplevel", "devtools.timeline", "cc"]
Event = dict[str, Any]


@contextmanager
def traced(browser: Browser) -> Iterator[list[Event]]:
    """What the threads of a browser do meanwhile; it is there when the block is left."""
    link, events, is_done = browser.new_browser_cdp_session(), list[Event](), list[bool]()
    link.on("Tracing.dataCollected", lambda message: events.extend(message["value"]))
    link.on("Tracing.tracingComplete", lambda _: is_done.append(True))
    link.send("Tracing.start", {"traceConfig": {"includedCategories": CATEGORIES}})
    yield events
    link.send("Tracing.end")
    while not is_done:
        browser.contexts[0].pages[0].wait_for_timeout(20)
    link.detach()


def of_main_thread(events: list[Event]) -> list[Event]:
    """What took time on the main thread of the page that drew most frames, in order; nothing if none was drawn."""
    frames = [(event["pid"], event["tid"]) for event in events if event["name"] == FRAME]
    thread = statistics.mode(frames) if frames else None
    own = [event for event in events if (event["pid"], event["tid"]) == thread and event["ph"] == "X"]
    return sorted(own, key=lambda event: (event["ts"], -event["dur"]))


def outermost(events: list[Event], names: set[str]) -> Iterator[Event]:
    """Those of some names that lie in no other of them."""
    until = 0.0
    for event in events:
        if event["name"] in names and event["ts"] >= until:
            until = event["ts"] + event["dur"]
            yield event


def by_frame(events: list[Event], names: set[str]) -> list[float]:
    """Milliseconds of a thread from each frame's end to the next one's, spent on events of some names."""
    ends = [event["ts"] + event["dur"] for event in events if event["name"] == FRAME]
    spent, n = [0.0] * len(ends), 0
    for event in outermost(events, names):
        while n < len(ends) and event["ts"] >= ends[n]:
            n += 1
        if n < len(ends):
            spent[n] += event.get("tdur", 0) / 1000
    return spent[1:]


def drawing_s(browser: Browser) -> float:
    """Processor time of the process that draws, so far."""
    link = browser.new_browser_cdp_session()
    processes = link.send("SystemInfo.getProcessInfo")["processInfo"]
    link.detach()
    return float(sum(one["cpuTime"] for one in processes if one["type"] == "GPU"))


class Hand:
    """A pointer that drags on the page's map."""

    def __init__(self, page: Page, steps: int) -> None:
        self._page, self._steps = page, steps
        self.let_go: Callable[[], None] = lambda: None

    def pan(self) -> None:
        """The map, in a zigzag about where it was."""
        self._drag(self._middle(), "left")

    def turn(self) -> None:
        """The map, turned about its middle."""
        self._drag(self._middle(), "right")

    def zoom(self) -> None:
        """In and out again, by the wheel."""
        self._page.mouse.move(*self._middle())
        for n in range(self._steps):
            self._page.mouse.wheel(0, -60 if n % 40 < 20 else 60)
        self.let_go = lambda: None

    def spot(self, name: str) -> None:
        """A place of the flight."""
        box = self._page.locator(f"[data-spot='{name}']").bounding_box()
        assert box is not None
        self._drag((box["x"] + box["width"] / 2, box["y"] + box["height"] / 2), "left")

    def building(self) -> None:
        """The building that the scenario draws."""
        script = """() => {
            const box = map.getContainer().getBoundingClientRect();
            const body = map.getStyle().sources.bodies.data.features.find(one => one.properties.path);
            const ring = body.geometry.coordinates[0].slice(0, 4);
            const mean = n => ring.reduce((sum, corner) => sum + corner[n] / 4, 0);
            const at = map.project([mean(0), mean(1)]);
            return [box.x + at.x, box.y + at.y];
        }"""
        x, y = self._page.evaluate(script)
        self._drag((x, y), "left")

    def _middle(self) -> tuple[float, float]:
        box = self._page.locator(".maplibregl-canvas").bounding_box()
        assert box is not None
        return box["x"] + 0.6 * box["width"], box["y"] + 0.6 * box["height"]

    def _drag(self, place: tuple[float, float], button: Any) -> None:
        mouse = self._page.mouse
        mouse.move(*place)
        mouse.down(button=button)
        for n in range(self._steps):
            away = 2 * abs((n + 15) % 60 - 30) - 30
            mouse.move(place[0] + away, place[1] + away / 2)
        self.let_go = lambda: mouse.up(button=button)


WAYS: dict[str, Callable[[Hand], None]] = {
    "pan": Hand.pan,
    "zoom": Hand.zoom,
    "via": lambda hand: hand.spot("via.0"),
    "goal": lambda hand: hand.spot("goal"),
    "building": Hand.building,
    "pan in space": Hand.pan,
    "turn in space": Hand.turn,
}


def measured(browser: Browser, page: Page, way: str, steps: int) -> list[str]:
    """A row of the table: what it costs to drag so."""
    hand = Hand(page, steps)
    if ("space" in way) != (page.get_by_role("button", name="3-D").get_attribute("aria-pressed") == "true"):
        page.get_by_role("button", name="3-D").click()
    page.keyboard.press("Home")
    page.wait_for_timeout(2500)
    drawn, begun = drawing_s(browser), time.perf_counter()
    with traced(browser) as events:
        WAYS[way](hand)
    seconds, drawn = time.perf_counter() - begun, drawing_s(browser) - drawn
    main = of_main_thread(events)
    with traced(browser) as after:
        hand.let_go()
        page.wait_for_timeout(3000)
    longest = max((one.get("tdur", 0) / 1000 for one in of_main_thread(after) if one["name"] == TASK), default=0.0)
    row = [way]
    for names in (SCRIPT, {TASK}):
        spent = by_frame(main, names)
        worst = [statistics.median(spent), statistics.quantiles(spent, n=20)[-1], max(spent)]
        row.append(", ".join(f"{value:.1f}" for value in worst))
    count = sum(event["name"] == FRAME for event in main)
    return [row[0], str(count), *row[1:], f"{1000 * drawn / count:.0f}", f"{count / seconds:.1f}", f"{longest:.0f}"]


def stopped(page: Page) -> None:
    """Without the planner, which wants the same processors."""
    page.wait_for_timeout(1500)
    page.evaluate("[...document.querySelectorAll('button')].find(one => one.textContent === 'Cancel')?.click()")


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("--buildings", type=int, nargs="+", default=[500, 5000])
    parser.add_argument("--width", type=int, default=1440)
    parser.add_argument("--height", type=int, default=900)
    parser.add_argument("--what", nargs="+", default=list(WAYS), choices=list(WAYS))
    parser.add_argument("--steps", type=int, default=120, help="of the pointer in one drag")
    arguments = parser.parse_args()
    viewport: Any = {"width": arguments.width, "height": arguments.height}
    for buildings in arguments.buildings:
        head = ("frames", "script: median, 95 %, worst", "main thread: median, 95 %, worst", "drawing", "a second")
        table = Table(f"{buildings} buildings", *head, "longest after")
        with tempfile.TemporaryDirectory() as name, sync_playwright() as play:
            scenario = town(buildings, Path(name))
            scenario.write_text(scenario.read_text() + OWN)
            browser = play.chromium.launch(executable_path=shutil.which("chromium"), args=SOFTWARE)
            with studio(scenario, Path(name)) as address:
                page = browser.new_page(viewport=viewport)
                page.set_default_timeout(PATIENCE_MS)
                page.goto(address)
                page.locator("[data-spot=goal]").wait_for()
                for way in arguments.what:
                    stopped(page)
                    table.add_row(*measured(browser, page, way, arguments.steps))
            browser.close()
        Console(width=150).print(table)


if __name__ == "__main__":
    main()
