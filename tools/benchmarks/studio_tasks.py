"""Ten more tasks of a day on the studio's page, and a newcomer's first flight: clicks, keys and seconds, by a script.

    python -m tools.benchmarks.studio_tasks

The first ten are those of `tools.generate.studio_pictures`. A click is a click, a drag or a drop; keys are those that
are pressed beside. The seconds are the script's, until what was asked for is there; a hand takes longer. Needs
playwright and Chromium, which draws by software.
"""

import shutil
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from playwright.sync_api import sync_playwright

from tools import command_line
from tools.generate.studio_pictures import PATIENCE_MS, SOFTWARE, Hands, proved, studio

MISSIONS = Path("missions")
TOWN = """<osm version="0.6"><node id="1" lat="39.1030" lon="121.8240"/><node id="2" lat="39.1030" lon="121.8242"/>
<node id="3" lat="39.1032" lon="121.8242"/><way id="9"><nd ref="1"/><nd ref="2"/><nd ref="3"/><nd ref="1"/>
<tag k="building" v="yes"/><tag k="height" v="9"/></way></osm>"""


class CountedHands(Hands):
    """Hands whose keys are counted too."""

    def __init__(self, page: Any) -> None:
        super().__init__(page)
        self.keys = 0

    def type(self, words: str, end: str = "Tab") -> None:
        """Write where the cursor is, in place of what is there, and press a key at the end."""
        self.keys += len(words) + 1
        self.page.keyboard.press("Control+a")
        self.page.keyboard.type(words)
        self.page.keyboard.press(end)

    def click(self, locator: Any) -> None:
        """Click an element."""
        self.clicks += 1
        locator.click()

    def item(self, seq: int) -> tuple[float, float]:
        """Where on the screen an item of the mission is."""
        script = """seq => {
            const home = map.getContainer().getBoundingClientRect();
            const found = map.querySourceFeatures("items").find(one => one.properties.seq === seq);
            const at = map.project(found.geometry.coordinates);
            return [home.x + at.x, home.y + at.y];
        }"""
        x, y = self.page.evaluate(script, seq)
        return x, y

    def pull(self, seq: int) -> None:
        """Drag an item."""
        self.clicks += 1
        x, y = self.item(seq)
        self.page.mouse.move(x, y)
        self.page.mouse.down()
        self.page.mouse.move(x + 25, y - 25, steps=4)
        self.page.mouse.up()

    def told(self, task: str, do: Callable[[], None], is_done: Callable[[], bool]) -> None:
        """Do it, wait until it is done, and tell what that took."""
        self.clicks = self.keys = 0
        begun = time.perf_counter()
        do()
        self.until(is_done)
        print(f"| {task} | {self.clicks} | {self.keys} | {time.perf_counter() - begun:.1f} |", flush=True)


def of_a_mission(hands: CountedHands) -> None:
    """What is done with a mission file, from the start page on."""
    page = hands.page

    def row(seq: int) -> Any:
        return page.locator(".items th button", has_text=f"{seq} ").first

    def undone(words: str) -> bool:
        return bool(page.locator(f"[title^='Undo'][title*='{words}']").count() == 1)

    def opened_and_moved() -> None:
        hands.click(page.get_by_role("button", name="campus.plan").first)
        page.locator(".chart .grip").first.wait_for(state="attached")
        hands.until(lambda: page.evaluate("window.map?.loaded() && map.querySourceFeatures('items').length > 6"))
        hands.click(row(7))
        page.wait_for_timeout(300)
        hands.pull(7)

    hands.told("a foreign mission opened, its 7th item moved", opened_and_moved, lambda: undone("item 7"))

    def put_in() -> None:
        hands.press("Waypoint after the item that is chosen")
        hands.clicks += 1
        x, y = hands.item(7)
        page.mouse.click(x + 40, y + 40)
        page.keyboard.press("Escape")

    hands.told("an item put in after it", put_in, lambda: undone("added"))

    def higher() -> None:
        hands.click(row(9))
        hands.click(page.get_by_role("spinbutton", name="Height"))
        hands.type("31.5")

    hands.told("an item's height changed", higher, lambda: undone("31.5"))

    def removed() -> None:
        hands.click(row(8))
        hands.keys += 1
        page.locator("body").press("Delete")

    hands.told("an item taken out", removed, lambda: undone("removed"))

    def measured() -> None:
        hands.press("Measure a distance")
        for seq in (3, 9):
            hands.clicks += 1
            page.mouse.click(*hands.item(seq))
            page.mouse.move(*hands.item(3))

    hands.told("a distance measured", measured, lambda: " m" in page.locator(".notice").inner_text())
    page.keyboard.press("Escape")

    def found() -> None:
        hands.click(page.get_by_label("Go to a place"))
        hands.type("51SVD9812528157", "Enter")

    hands.told("a place found by MGRS", found, lambda: page.get_by_text("from home").count() == 1)


def of_a_flight(hands: CountedHands, folder: Path) -> None:
    """What is done with a scenario that is proved, up to the vehicle in the air."""
    page = hands.page
    proved(page)
    (folder / "town.osm").write_text(TOWN, encoding="utf-8")
    choose = page.locator("details:has(summary:text('Maps and missions')) input[type=file]")

    def dropped() -> None:
        hands.clicks += 1  # the drop
        choose.set_input_files(folder / "town.osm")
        hands.press("Buildings to fly round")

    hands.told("buildings of an .osm extract", dropped, lambda: 'file = "town' in hands.text())
    proved(page)

    def asked() -> None:
        hands.open("Fly it")
        hands.click(page.get_by_label("a vehicle, or SITL"))
        hands.press("Who is there?")

    hands.told("who is on the links", asked, lambda: page.get_by_text("127.0.0.1:14550:").count() > 0)
    page.get_by_label("the built-in autopilot").click()
    page.get_by_role("button", name="Upload").click()
    page.get_by_role("button", name="Arm and start …").click()
    page.get_by_role("dialog").locator("input").fill("campus")
    page.get_by_role("dialog").get_by_role("button", name="Arm and start").click()
    page.get_by_role("button", name="Hold").wait_for()

    def held() -> None:
        hands.press("Hold")
        page.get_by_role("button", name="Go on").wait_for()
        hands.press("Go on")

    hands.told("held in flight, and sent on", held, lambda: page.get_by_role("button", name="Hold").count() == 1)

    def returns() -> bool:
        return bool(page.get_by_text("it returns home").count() > 0)

    hands.told("sent home in flight", lambda: hands.press("Return now"), returns)


def newcomer(hands: CountedHands) -> None:
    """A building drawn between start and goal of a scenario that was begun by `--new`, and a flight round it."""
    page = hands.page
    proved(page)

    def drawn() -> None:
        hands.press("Building, corner by corner")
        boxes = [page.locator(f"[data-spot={name}]").bounding_box() for name in ("start", "goal")]
        (sx, sy), (gx, gy) = ((box["x"] + box["width"] / 2, box["y"] + box["height"] / 2) for box in boxes)
        mx, my, side = (sx + gx) / 2, (sy + gy) / 2, abs(gy - sy) / 6
        for east, north in ((-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)):
            hands.clicks += 1
            page.mouse.click(mx + east * side, my - north * side)
        hands.click(page.get_by_role("region", name="Chosen").get_by_label("Height"))
        hands.type("40", "Enter")

    def is_round() -> bool:
        verdict = page.locator(".verdict").inner_text()
        is_over = page.get_by_text("The flight passes over it").count() > 0
        return "Proved" in verdict and "building 1" in verdict and not is_over and "height = 40" in hands.text()

    hands.told("a newcomer's flight round a building that he draws", drawn, is_round)


def main() -> None:
    command_line(__doc__).parse_args()
    with tempfile.TemporaryDirectory() as name, sync_playwright() as play:
        folder = Path(name)
        browser = play.chromium.launch(executable_path=shutil.which("chromium"), args=SOFTWARE)

        def page_on(address: str) -> Any:
            page = browser.new_page(viewport={"width": 1280, "height": 800}, reduced_motion="reduce")
            page.set_default_timeout(PATIENCE_MS)
            page.goto(address)
            return page

        for file in ("campus.plan", "campus.toml"):
            shutil.copy(MISSIONS / file, folder)
        with studio(None, folder) as address:
            of_a_mission(CountedHands(page_on(address)))
        with studio(folder / "campus.toml", folder) as address:
            of_a_flight(CountedHands(page_on(address)), folder)
        begun = time.perf_counter()
        with studio(folder / "first.toml", folder, "--new", "47.397742", "8.545594", "488") as address:
            newcomer(CountedHands(page_on(address)))
        print(f"with the program's start: {time.perf_counter() - begun:.1f} s")
        browser.close()


if __name__ == "__main__":
    main()
