import json
from typing import Any

from tests.studio.chromium import (
    address,
    browser,
    in_a_browser,
    own_page,
    page,
    proved,
    rewrite,
    scenario_of,
    until,
    window,
)
from tests.studio.conftest import MEADOW
from tests.studio.pointing import Hand, feature, middle_of

__all__ = ["address", "browser", "own_page", "page", "window"]
pytestmark = in_a_browser

SEEN = "[map.getZoom(), map.getCenter().lng, map.getCenter().lat]"


def test_a_double_click_closes_a_building_and_the_map_stays(page: Any) -> None:
    proved(page)
    page.locator("body").press("Home")
    Hand(page).settle()
    before = page.evaluate(SEEN)
    box = page.locator(".maplibregl-canvas").bounding_box()
    page.locator("body").press("b")
    for east, north in ((0.75, 0.3), (0.85, 0.3)):
        page.mouse.click(box["x"] + east * box["width"], box["y"] + north * box["height"])
    page.mouse.dblclick(box["x"] + 0.85 * box["width"], box["y"] + 0.4 * box["height"])
    until(page, "document.querySelector('textarea').value.includes('building 3')")
    assert len(scenario_of(page).split("footprint = ")[1].split("], [")) == 3
    assert page.evaluate(SEEN) == before


def test_flight_over_a_building_is_remarked(page: Any) -> None:
    rewrite(page, scenario_of(page).replace("height = 25.0", "height = 2.0").replace("height = 22.0", "height = 2.0"))
    proved(page)
    page.locator("body").press("Home")
    Hand(page).click(feature("roofs", "of.name === 'barn' && of.top < 3", aside=(0, 12)))
    page.get_by_text("The flight passes over it.").wait_for()
    rewrite(page, scenario_of(page).replace("height = 2.0", "height = 25.0", 1))
    page.get_by_text("The flight passes over it.").wait_for(state="detached")
    proved(page)
    assert page.get_by_text("The flight passes over it.").count() == 0


def test_the_side_stays_while_another_plan_is_made(page: Any) -> None:
    proved(page)
    items = page.locator(".items")
    items.first.wait_for()
    rewrite(page, scenario_of(page).replace("up = 10.0\n\n[bounds]", "up = -3.0\n\n[bounds]"))
    page.locator(".refusal").first.wait_for()
    assert items.count() == 1
    assert page.locator(".past .items").evaluate("one => one.closest('[inert]') !== null")
    page.get_by_role("button", name="Goal to").click()
    until(page, "document.querySelector('.past') === null")


def test_all_of_the_flight_is_printed_and_the_map_is_then_as_it_was(page: Any) -> None:
    proved(page)
    page.evaluate("map.jumpTo({ zoom: map.getZoom() + 3 })")
    before = page.evaluate(SEEN)
    page.evaluate("window.print = () => { window.printed = map.getZoom(); }")
    page.locator("body").press("Control+p")
    until(page, "window.printed !== undefined")
    assert page.evaluate("window.printed") < before[0] - 1
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    until(page, "map.getContainer().style.width === ''")
    assert page.evaluate(SEEN) == before


def test_the_goal_is_dragged_and_undone(page: Any) -> None:
    proved(page)
    page.locator("body").press("Home")

    def look() -> None:
        page.get_by_text("While you drag").wait_for()
        assert page.locator(".profile.past, .past .bindings").count() == 2
        assert scenario_of(page) == MEADOW.read_text()

    Hand(page).drag(middle_of("[data-spot=goal]"), -20, -30, look)
    until(page, "!document.querySelector('textarea').value.includes('east = 60.0')")
    assert "a comment that stays" in scenario_of(page)
    page.locator(".unsaved").wait_for()
    page.keyboard.press("Control+z")
    until(page, f"document.querySelector('textarea').value === {json.dumps(MEADOW.read_text())}")
    page.locator(".saved").wait_for()
