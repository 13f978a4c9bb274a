"""Make the pictures of docs/studio.md, and time its ten tasks by a script that clicks on the campus.

    python -m tools.generate.studio_pictures out/

Needs playwright and Chromium, which renders by software. Reports for each task the clicks, and the seconds from the
first click to the changed scenario; a user needs more.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from playwright.sync_api import sync_playwright

from tools import command_line

PATIENCE_MS = 180_000
CAMPUS = Path("missions/campus.toml")
SOFTWARE = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]


@contextmanager
def studio(scenario: Path | None, folder: Path, *options: str) -> Iterator[str]:
    """Yield the address of a studio on a scenario, or of its start page; `folder` holds its state."""
    command = [sys.executable, "-m", "ipoa_mission", "studio", *([] if scenario is None else [str(scenario)])]
    environment = os.environ | {"XDG_STATE_HOME": str(folder / "state"), "PYTHONPATH": str(Path.cwd())}
    with subprocess.Popen(
        [*command, "--no-browser", *options], stdout=subprocess.PIPE, text=True, cwd=folder, env=environment
    ) as process:
        assert process.stdout is not None
        try:
            yield next(found[0] for line in process.stdout if (found := re.search(r"http://\S+", line)))
        finally:
            process.terminate()


class Hands:
    """Click on a page, and count clicks and time."""

    def __init__(self, page: Any) -> None:
        self.page = page
        self.clicks = 0

    def press(self, name: str) -> None:
        """Click a button by its name."""
        self.clicks += 1
        self.page.get_by_role("button", name=name, exact=True).click()

    def point(self, east: float, north: float) -> None:
        """Click the map, at meters from home."""
        self.clicks += 1
        self.page.mouse.click(*self.place(east, north))

    def drag(self, what: str, east: float, north: float) -> None:
        """Drag home, start or goal to a place."""
        self.clicks += 1
        box = self.page.locator(f"[data-spot={what}]").bounding_box()
        self.page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        self.page.mouse.down()
        self.page.mouse.move(*self.place(east, north), steps=5)
        self.page.mouse.up()

    def write(self, label: str, value: str) -> None:
        """Write into a field: one click and some keys."""
        self.clicks += 1
        field = self.page.get_by_label(label)
        field.fill(value)
        field.press("Tab")

    def open(self, panel: str) -> None:
        """Open a panel."""
        self.clicks += 1
        self.page.locator("summary", has_text=panel).click()

    def place(self, east: float, north: float) -> tuple[float, float]:
        """Return the screen position of a place on the map."""
        script = """([east, north]) => {
            const home = map.getContainer().getBoundingClientRect();
            const narrow = Math.cos(39.101 * Math.PI / 180) * 111320;
            const at = map.project([121.82 + east / narrow, 39.101 + north / 111035]);
            return [home.x + at.x, home.y + at.y];
        }"""
        x, y = self.page.evaluate(script, [east, north])
        return x, y

    def text(self) -> str:
        return str(self.page.locator("textarea").input_value())

    def until(self, meant: Callable[[], bool]) -> None:
        """Wait for a condition."""
        while not meant():
            self.page.wait_for_timeout(20)


def tasks(hands: Hands) -> dict[str, tuple[Callable[[], None], Callable[[], bool]]]:
    """Return the actions and the end condition of each task, by its name in the docs."""

    def drawn(tool: str) -> None:
        hands.press(tool)
        for corner in ((250, 115), (275, 115), (275, 135), (250, 135), (250, 115)):
            hands.point(*corner)

    def has(words: str, times: int = 1) -> Callable[[], bool]:
        return lambda: hands.text().count(words) >= times

    def mast() -> None:
        hands.press("Mast or tree")
        hands.point(140, 65)

    def via() -> None:
        hands.press("Via point")
        hands.point(205, 115)

    def fly() -> None:
        hands.open("Fly it")
        hands.press("Upload")

    height = "Height of all places"
    return {
        "the goal to behind a building": (lambda: hands.drag("goal", 200, 190), has("east = 2", 0)),
        "a via point": (via, has("[[via]]")),
        "a mast": (mast, has('name = "mast 27"')),
        "a building of four corners": (lambda: drawn("Building, corner by corner"), has('name = "building 28"')),
        "a keep-out fence of four corners": (lambda: drawn("Keep-out fence"), has("[[fence]]")),
        "the height of all places": (
            lambda: hands.write(height, "22"),
            has("height_above_ground = 22"),
        ),
        "the cruise speed": (lambda: hands.write("Cruise speed", "10"), has("cruise_speed = 10")),
        "the last change taken back": (lambda: hands.press("Undo"), has("cruise_speed = 15")),
        "saved": (lambda: hands.press("Save"), lambda: hands.page.locator(".saved").count() == 1),
        "on the vehicle, read back": (fly, lambda: hands.page.get_by_text("Arm and start …").count() == 1),
    }


def proved(page: Any) -> None:
    page.locator(".verdict :is(.good, .amber)").first.wait_for()
    page.locator(".strip .way").first.wait_for()
    page.wait_for_timeout(700)


def picture(page: Any, file: Path, **how: Any) -> None:
    """Save a screenshot after the map is drawn."""
    page.wait_for_timeout(300)
    while not page.evaluate("map.loaded() && !map.isMoving()"):
        page.wait_for_timeout(100)
    page.wait_for_timeout(500)
    page.screenshot(path=file, **how)


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("out", type=Path)
    out = parser.parse_args().out
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as play:
        scenario = Path(shutil.copy(CAMPUS, folder))
        browser = play.chromium.launch(executable_path=shutil.which("chromium"), args=SOFTWARE)
        with studio(scenario, Path(folder)) as address:

            def opened(width: int, height: int, scheme: str) -> Any:
                page = browser.new_page(viewport={"width": width, "height": height}, color_scheme=scheme)
                page.set_default_timeout(PATIENCE_MS)
                page.on("console", lambda message: print(f"console: {message.text}"))
                page.on("pageerror", lambda error: print(f"error: {error}"))
                page.goto(address)
                proved(page)
                return page

            for name, width, height, scheme in (
                ("1280", 1280, 800, "light"),
                ("dark", 1280, 800, "dark"),
                ("390", 390, 844, "light"),
            ):
                page = opened(width, height, scheme)
                page.get_by_label("Moment of the flight").fill("250")
                picture(page, out / f"studio-{name}.png")
                if name == "390":
                    picture(page, out / f"studio-{name}-whole.png", full_page=True)
                if name != "390":
                    page.get_by_role("button", name="3-D").click()
                    picture(page, out / f"studio-{name}-space.png")
                page.close()
            page = opened(1280, 800, "light")
            hands = Hands(page)
            for task, (do, is_done) in tasks(hands).items():
                hands.clicks, begun = 0, time.perf_counter()
                if task == "on the vehicle, read back":
                    proved(page)
                    begun = time.perf_counter()
                do()
                hands.until(is_done)
                print(f"{task}: {hands.clicks} clicks, {time.perf_counter() - begun:.2f} s")
                number = list(tasks(hands)).index(task) + 1
                picture(page, out / f"task-{number:02d}.png")
            page.get_by_role("button", name="Arm and start …").click()
            picture(page, out / "studio-start.png")
            page.get_by_role("dialog").locator("input").fill("campus")
            page.get_by_role("dialog").get_by_role("button", name="Arm and start").click()
            page.get_by_text("flying for").wait_for()
            page.wait_for_timeout(4000)
            page.screenshot(path=out / "studio-fly.png")
            page.close()
        browser.close()


if __name__ == "__main__":
    main()
