import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import shapely

from ipoa_mission import read_mission, read_scenario
from ipoa_mission.geodesy import Geodetic, LocalFrame
from tests.studio import chromium as own
from tests.studio.chromium import address, browser, own_page, page, proved, pytestmark, scenario_of, until, window
from tests.studio.pointing import Hand, feature

__all__ = ["address", "browser", "own_page", "page", "pytestmark", "window"]

LEFT, RIGHT, UP, DOWN = (f"Arrow{direction}" for direction in ("Left", "Right", "Up", "Down"))


def press(page: Any, *keys: str) -> None:
    """Press keys; a number repeats the key before it."""
    for key in keys:
        name, _, times = key.partition("*")
        for _ in range(int(times or 1)):
            page.keyboard.press(name)


def wait_for_words(page: Any, words: str) -> None:
    """Wait for a screen reader's words."""
    page.locator(".spoken", has_text=words).wait_for()


def undone(page: Any, words: str) -> None:
    until(page, f"document.querySelector('[title^=Undo]').title === 'Undo: {words}'")


@pytest.fixture
def at_home(page: Any) -> Iterator[Any]:
    proved(page)
    page.evaluate("document.activeElement.blur()")
    press(page, "Home")
    yield page
    press(page, "Escape", "Escape")


def test_a_flight_is_planned_round_a_building_drawn_by_keyboard(own_page: Any, address: tuple[str, Path]) -> None:
    page = own_page
    proved(page)
    press(page, "Home", "b")
    wait_for_words(page, "30 m east, 0 m north of home")  # the middle of the map
    assert page.evaluate("document.activeElement.className").startswith("maplibregl-canvas")
    press(page, f"Shift+{RIGHT}", f"{RIGHT}*2", f"Shift+{DOWN}*2", "Enter")
    wait_for_words(page, "Corner 1.")
    press(page, f"{RIGHT}*4", "Enter", f"Shift+{UP}*9", "Enter")
    wait_for_words(page, "Corner 3. 90.0 m; around")
    press(page, "Backspace")
    wait_for_words(page, "The last corner is taken back; 2 left.")
    press(page, f"Shift+{DOWN}*6", "Enter", f"{LEFT}*4", "Enter", "Enter")
    wait_for_words(page, "Closed")
    until(page, "document.querySelector('textarea').value.includes('building 3')")
    height = page.locator("label", has_text="height").locator("input").first
    height.press("Control+a")
    page.keyboard.type("29")
    press(page, "Tab")
    until(page, "document.querySelector('textarea').value.includes('height = 29')")
    proved(page)
    page.get_by_role("button", name="Mission files").focus()
    press(page, "Enter")
    page.get_by_text("written: meadow.plan").wait_for()
    press(page, "Control+s")
    page.locator(".saved").wait_for()
    corners = [[42.0, -20.0], [46.0, -20.0], [46.0, 10.0], [42.0, 10.0]]
    assert tomllib.loads(address[1].read_text())["obstacles"][2]["footprint"] == corners
    mission, frame = read_mission(address[1].with_suffix(".plan")), read_scenario(address[1]).frame
    places = [item for item in mission.items if item.has_position]
    path = [frame.local(Geodetic(item.latitude_deg, item.longitude_deg, 510.0))[:2] for item in places]
    assert shapely.LineString(path).distance(shapely.Polygon(corners)) > 1.5  # its hull and the safety distance


def test_places_are_put_moved_and_taken_out(at_home: Any) -> None:
    page, before = at_home, scenario_of(at_home)
    press(page, "w", f"Shift+{DOWN}*2", "Enter")
    wait_for_words(page, "Point added.")
    undone(page, "via point added")
    until(page, "document.querySelector('textarea').value.includes('[[via]]')")
    press(page, "Backspace")
    until(page, "!document.querySelector('textarea').value.includes('[[via]]')")
    press(page, "Escape")
    wait_for_words(page, "The crosshair is gone.")
    press(page, "c", f"Shift+{UP}*2", f"{DOWN}*2", "Enter")
    wait_for_words(page, "silo taken")
    press(page, f"Shift+{LEFT}", "Escape")
    wait_for_words(page, "Let go where it was.")
    press(page, f"Shift+{RIGHT}*4", f"Shift+{DOWN}", f"{DOWN}*8", "Enter")
    wait_for_words(page, "goal taken")
    press(page, f"Shift+{LEFT}", "Enter")
    undone(page, "goal moved")
    assert before.replace("east = 60.0", "east = 50.0") == scenario_of(page)


def test_an_area_to_be_surveyed_is_drawn_and_its_corner_moved(own_page: Any) -> None:
    page = own_page
    proved(page)
    press(page, "Home", "a")
    wait_for_words(page, "30 m east, 0 m north of home")
    press(page, f"Shift+{LEFT}*3", "Enter", f"Shift+{RIGHT}*2", "Enter", f"Shift+{UP}*2", "Enter", "Enter")
    undone(page, "area drawn")
    corner = page.locator("[data-grip='survey.polygon.0.0.1']")
    corner.focus()
    press(page, f"Shift+{RIGHT}")
    until(page, "document.querySelector('[title^=Undo]').title.includes('corner moved')")
    until(page, "document.querySelector('textarea').value.includes('[30.0, 0.0]')")


def test_items_of_a_mission_are_moved_put_in_and_taken_out(own_page: Any, address: tuple[str, Path]) -> None:
    page = own_page
    proved(page)
    page.locator("summary", has_text="Maps and missions").press("Enter")
    page.locator("input[type=file]").set_input_files(own.REPOSITORY / "missions" / "sitl.plan")
    page.get_by_role("button", name="Open it by itself").press("Enter")
    page.get_by_role("heading", name="sitl: a mission file").wait_for()
    Hand(page).settle()
    page.locator(".items").get_by_role("button", name=re.compile("^(! )?4 ")).press("Enter")
    Hand(page).at(feature("items", "of.icon === 'item4!'"))
    press(page, "c", "Enter")
    wait_for_words(page, "item 4 taken")
    press(page, f"{UP}*3", f"Shift+{RIGHT}", "Enter")
    undone(page, "item 4 moved")
    press(page, "Control+s")
    page.locator(".saved").wait_for()
    before, after = (read_mission(folder / "sitl.plan") for folder in (own.REPOSITORY / "missions", address[1].parent))
    frame, was, now = LocalFrame(before.home), before.items[3], after.items[3]
    there, here = (frame.local(Geodetic(item.latitude_deg, item.longitude_deg))[:2] for item in (now, was))
    assert there - here == pytest.approx([10.0, 3.0], abs=0.05)
    press(page, "w", f"Shift+{UP}", "Enter", "Escape", "Delete")  # sooner than the list shows it
    undone(page, "item 5 removed")
    page.locator(".items summary", has_text=f"({len(before.items)})").wait_for()
    press(page, "Delete", "Delete")
    page.locator(".items summary", has_text=f"({len(before.items) - 2})").wait_for()
