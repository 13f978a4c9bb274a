"""Find, wait for and press places of the page by JavaScript, in any browser; a place is [x, y] or null."""

import json
import time
from collections.abc import Callable
from typing import Any

PATIENCE_S = 120.0
#: Judged, not dragged, and the map drawn.
SETTLED = """(
    document.querySelector(".verdict :is(.good, .amber, .refusal)") !== null
    && !/While you drag|Looking at|coarse path|laid at once/.test(document.querySelector(".verdict").textContent)
    && document.querySelector(".progress, .past, .flights.stale") === null
    && (window.map?.loaded() ?? false) && !map.isMoving()
)"""
SAME = 3  # looks in a row, each after two frames
FRAMES = "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"


def element(script: str) -> str:
    """Return the middle of an element, where it is on top."""
    return f"""(() => {{
        const one = {script}, box = one?.getBoundingClientRect();
        if (!box) return null;
        const place = [box.x + box.width / 2, box.y + box.height / 2], top = document.elementFromPoint(...place);
        return top && (one === top || one.contains(top)) ? place : null;
    }})()"""


def middle_of(selector: str, number: int = 0) -> str:
    """Return the middle of an element by selector and number."""
    return element(f"document.querySelectorAll({json.dumps(selector)})[{number}]")


def stroke(selector: str, number: int = 0) -> str:
    """Return where a drawing's stroke begins, whatever is on top."""
    return f"""(() => {{
        const box = document.querySelectorAll({json.dumps(selector)})[{number}]?.getBoundingClientRect();
        return box ? [box.x, box.y] : null;
    }})()"""


def feature(layer: str, about: str, aside: tuple[float, float] = (0.0, 0.0)) -> str:
    """Return the middle of a feature in a layer; `about`: a condition on its properties `of`."""
    return f"""(() => {{
        const box = map.getCanvas().getBoundingClientRect(), layers = [{json.dumps(layer)}];
        const one = map.queryRenderedFeatures({{ layers }}).find(({{ properties: of }}) => {about});
        if (!one) return null;
        const places = one.geometry.coordinates.flat(Infinity), mean = n => {{
            const values = places.filter((_, m) => m % 2 === n);
            return (Math.min(...values) + Math.max(...values)) / 2;
        }};
        const at = map.project([mean(0), mean(1)]).add({{ x: {aside[0]}, y: {aside[1]} }});
        const there = map.queryRenderedFeatures(at, {{ layers }}).some(({{ properties: of }}) => {about});
        return there ? [box.x + at.x, box.y + at.y] : null;
    }})()"""


def settled(evaluate: Callable[[str], Any], place: str = "[0, 0]", condition: str = SETTLED) -> Any:
    """Return where something stays once the page has settled, or fulfills another condition.

    `evaluate` awaits a promise of the page.
    """
    before, same, until_s = None, 0, time.monotonic() + PATIENCE_S
    while time.monotonic() < until_s:
        now = evaluate(f"{FRAMES}.then(() => {condition} ? {place} : null)")
        same = same + 1 if now is not None and now == before else 0
        before = now
        if same == SAME - 1:
            return now
        time.sleep(0.03)
    raise AssertionError(f"never settled, last at {before}: {place}")


class Hand:
    """The mouse on a page of Chromium."""

    def __init__(self, page: Any) -> None:
        self._page = page

    def at(self, place: str) -> tuple[float, float]:
        x, y = settled(self._page.evaluate, place)
        return float(x), float(y)

    def settle(self) -> None:
        self.at("[0, 0]")

    def click(self, place: str) -> None:
        self._page.mouse.click(*self.at(place))

    def drag(self, place: str, right: float, down: float, then: Callable[[], object] = lambda: None) -> None:
        """Drag by pixels; `then`: before it is let go."""
        x, y = self.at(place)
        mouse = self._page.mouse
        mouse.move(x, y)
        mouse.down()
        mouse.move(x + right, y + down, steps=4)
        then()
        mouse.up()
