import json
import re
from pathlib import Path
from typing import Any

import pytest

from ipoa_mission import Forecast, read_mission
from ipoa_mission.autopilot.failsafe import Contingency
from ipoa_mission.forecast.contingency.contingencies import Contingencies, Grade, contingencies_of
from ipoa_mission.report.panels.contingency_panel import GRADE_LOOKS
from ipoa_mission.scenario import parse_scenario
from tests.forecast.test_contingencies_now import BATTERY
from tests.studio.chromium import (
    REPOSITORY,
    USUAL,
    address,
    browser,
    own_page,
    page,
    places,
    proved,
    pytestmark,
    rewrite,
    scenario_of,
    serious,
    until,
    window,
)
from tests.studio.conftest import MEADOW
from tests.studio.pointing import Hand, feature, stroke

__all__ = ["address", "browser", "own_page", "page", "pytestmark", "window"]


def test_candidates_stand_side_by_side(own_page: Any) -> None:
    proved(own_page)
    before = scenario_of(own_page)
    own_page.get_by_role("button", name="Keep this one").click()
    own_page.get_by_label("Cruise speed").fill("4")
    own_page.get_by_label("Cruise speed").press("Tab")
    cells = "[...document.querySelectorAll('[aria-label=\"Candidates\"] tbody tr:first-child td')]"
    times = f"{cells}.map(cell => parseFloat(cell.textContent))"
    until(own_page, f"({times}).length === 2 && ({times})[1] > ({times})[0]")  # slower takes longer
    assert own_page.get_by_role("row", name="clearance predicted").is_visible()
    assert own_page.evaluate("document.documentElement.scrollHeight <= innerHeight")  # the side alone scrolls
    own_page.get_by_role("button", name="Take", exact=True).click()
    until(own_page, f"document.querySelector('textarea').value === {json.dumps(before)}")
    own_page.reload()
    until(own_page, f"{cells}.length > 0")  # kept over a reload
    own_page.get_by_label("forget A").click()


#: Notes of a flight: a busy machine may look only after the landing.
SEEN_FLYING = """() => new MutationObserver(() => {
    window.seenFlying ||= document.body.innerText.includes("flying for");
}).observe(document.body, {subtree: true, childList: true, characterData: true})"""


def test_a_flight_is_started_by_name_and_watched(own_page: Any) -> None:
    proved(own_page)
    own_page.locator("summary", has_text="Fly it").click()
    own_page.get_by_label("Speed-up").fill("8")
    own_page.get_by_role("button", name="Upload").click()
    own_page.get_by_role("button", name="Arm and start …").click()
    dialog = own_page.get_by_role("dialog")
    assert "built-in ardupilot, system 1" in dialog.inner_text()
    start = dialog.get_by_role("button", name="Arm and start")
    assert start.is_disabled()
    dialog.locator("input").fill("meadow")
    own_page.evaluate(SEEN_FLYING)
    start.click()
    own_page.get_by_text("✓ Landed").wait_for()
    assert own_page.evaluate("window.seenFlying")
    assert own_page.locator(".chart .flown").count() == 1
    assert int(own_page.get_by_label("Moment of the flight").input_value()) > 0  # it went with the vehicle


def test_a_building_is_drawn_named_and_saved(page: Any, address: tuple[str, Path]) -> None:
    name = '<img src="https://evil.example/x" onerror="alert(1)">'
    proved(page)  # a new page hears no keys yet
    page.keyboard.press("b")
    for place in places(page, (0.2, 0.3), (0.3, 0.3), (0.3, 0.4), (0.2, 0.4)):
        page.mouse.click(*place)
    page.keyboard.press("Enter")
    until(page, "document.querySelector('textarea').value.split('[[obstacles]]').length === 4")  # it has come back
    field = page.locator("label", has_text="Name").locator("input")
    field.fill(name)
    proved(page)  # an answer keeps what is being typed
    assert field.input_value() == name
    field.press("Tab")
    page.get_by_role("heading", name=name).wait_for()  # text, not markup
    assert page.locator("img").count() == 0
    page.keyboard.press("Control+s")
    until(page, "document.querySelector('.saved') !== null")
    written = address[1].read_text()
    assert written.count("[[obstacles]]") == 3
    assert written.startswith(MEADOW.read_text().rstrip("\n"))
    page.reload()
    until(page, "window.map?.isStyleLoaded()")
    assert scenario_of(page) == written


def test_a_map_is_dropped(page: Any, tmp_path: Path, address: tuple[str, Path]) -> None:
    ring = [[8.5002, 47.2999], [8.5003, 47.2999], [8.5003, 47.30], [8.5002, 47.2999]]
    file = tmp_path / "town.geojson"
    shape = {"type": "Polygon", "coordinates": [ring]}
    feature = {"type": "Feature", "properties": {"building": "yes", "height": "9"}, "geometry": shape}
    file.write_text(json.dumps({"type": "FeatureCollection", "features": [feature]}))
    page.locator("summary", has_text="Maps and missions").click()
    page.locator("input[type=file]").set_input_files(file)
    page.get_by_role("button", name="Buildings to fly round").click()
    until(page, """document.querySelector('textarea').value.includes('file = "town.geojson"')""")
    proved(page)
    assert (address[1].parent / "town.geojson").read_bytes() == file.read_bytes()
    page.locator("summary", has_text="Maps and missions").click()


def test_a_mission_is_dropped_opened_and_changed_item_by_item(own_page: Any, address: tuple[str, Path]) -> None:
    proved(own_page)
    own_page.locator("summary", has_text="Maps and missions").click()
    own_page.locator("input[type=file]").set_input_files(REPOSITORY / "missions" / "sitl.plan")
    own_page.get_by_role("button", name="Open it by itself").click()
    own_page.get_by_role("heading", name="sitl: a mission file").wait_for()
    own_page.get_by_label("In the world of").select_option("")
    own_page.get_by_text("no clearance is looked at").wait_for()
    hand = Hand(own_page)
    own_page.locator(".items").get_by_role("button", name=re.compile("^(! )?4 ")).click()
    hand.drag(feature("items", "of.icon === 'item4!'"), 30, -30)
    own_page.locator(".unsaved").wait_for()
    hand.drag(stroke(".chart .grip", 1), 0, -15)
    until(own_page, "document.querySelector('[title^=\"Undo\"]').title.includes('height')")
    own_page.get_by_role("button", name="Undo").click()
    until(own_page, "!document.querySelector('[title^=\"Undo\"]').title.includes('height')")
    own_page.locator(".items").get_by_role("button", name=re.compile("^(! )?4 ")).click()
    field = own_page.get_by_role("spinbutton", name="Height")
    own_page.get_by_label("Height counts from").select_option("10")  # PX4 takes no such item
    until(own_page, "document.querySelectorAll('.verdict .refusal .bad.chosen').length > 0")
    assert own_page.get_by_label("Chosen item").locator(".bad").count() == 0  # each finding has one place
    own_page.get_by_label("Height counts from").select_option("3")
    until(own_page, "document.querySelectorAll('.verdict .refusal .bad.chosen').length === 0")
    field.fill("31.5")
    field.press("Tab")
    until(own_page, "/31[.]5/.test(document.querySelector('textarea').value)")
    own_page.keyboard.press("Control+s")
    own_page.locator(".saved").wait_for()
    before, after = (read_mission(folder / "sitl.plan") for folder in (REPOSITORY / "missions", address[1].parent))
    changed = [
        n for n, pair in enumerate(zip(before.items, after.items, strict=True), 1) if repr(pair[0]) != repr(pair[1])
    ]
    assert changed == [4]
    assert after.items[3].altitude == 31.5
    own_page.set_viewport_size({"width": 390, "height": 844})
    assert own_page.evaluate("document.documentElement.scrollWidth") <= 390
    own_page.set_viewport_size(USUAL)
    own_page.locator("summary", has_text="Fly it").click()
    own_page.get_by_label("Speed-up").fill("8")
    own_page.get_by_role("button", name="Upload").click()
    own_page.get_by_text("neither clearance nor contingencies were checked").wait_for()
    own_page.get_by_role("button", name="Arm and start …").click()
    own_page.get_by_role("dialog").locator("input").fill("sitl")
    own_page.get_by_role("dialog").get_by_role("button", name="Arm and start").click()
    own_page.get_by_role("button", name="Hold", exact=True).click()
    own_page.get_by_role("button", name="Go on").wait_for()
    own_page.locator(".figures small", has_text=re.compile(r"^0[.]0 m/s$")).wait_for()  # it brakes for seconds
    at = int(own_page.get_by_label("Moment of the flight").input_value())
    own_page.wait_for_timeout(1000)  # 8 s of the flight
    assert abs(int(own_page.get_by_label("Moment of the flight").input_value()) - at) <= 2  # it stays where it holds
    own_page.get_by_role("button", name="Go on").click()
    own_page.get_by_text("✓ Landed").wait_for()


def test_page_opens_proved(page: Any) -> None:
    proved(page)
    assert "required" in page.locator(".verdict").inner_text()
    assert page.locator(".chart .planned").get_attribute("d").startswith("M")
    assert page.title().endswith("meadow · studio")
    page.get_by_role("button", name="Ways home").click()
    until(page, "map.querySourceFeatures('homeward').length > 0")
    page.get_by_role("button", name="Ways home").click()


def test_an_item_is_chosen_in_list_map_and_profile_alike(page: Any) -> None:
    proved(page)
    page.locator(".items button").nth(2).click()  # the speed before it lies nowhere
    until(page, "['.items tr.chosen', '.chart .mark.chosen'].every(one => document.querySelectorAll(one).length === 1)")
    assert float(page.get_by_label("Moment of the flight").input_value()) > 0
    icons = "map.querySourceFeatures('items').map(one => one.properties.icon).filter(icon => icon.endsWith('!'))"
    until(page, f"{icons}.length > 0")


def test_trees_wires_and_the_number_of_a_hidden_item_are_seen(page: Any) -> None:
    proved(page)
    thing = '\n[[obstacles]]\nkind = "cylinder"\nname = "{}"\neast = {}\nnorth = -25.0\nradius = 2.0\nheight = 5.0\n'
    named = (("tree 51 m NE of home (node/1)", 45), ("20 kV line (way/2)", 5))
    rewrite(page, MEADOW.read_text() + "".join(thing.format(*names) for names in named))
    proved(page)
    looks = "new Set(map.querySourceFeatures('bodies').map(one => one.properties.look))"
    until(page, f"{looks}.size === 3 && {looks}.has('tree') && {looks}.has('wire') && {looks}.has('')")
    until(page, "map.queryRenderedFeatures({layers: ['wires']}).length > 0")
    until(page, "map.queryRenderedFeatures({layers: ['items']}).some(one => one.properties.hidden)")


def test_the_map_stays_where_it_is_while_a_plan_is_awaited_or_refused(page: Any) -> None:
    proved(page)
    before = page.locator(".map").bounding_box()
    rewrite(page, MEADOW.read_text() + "\n[[via]]\neast = 30.0\nnorth = 0.0\nup = 10.0\n")  # inside of the barn
    page.get_by_text("via 1: nothing can fly there").wait_for()
    assert page.locator("[data-spot='via.0'].lit").count() == 1
    assert page.locator(".map").bounding_box() == before
    page.get_by_role("button", name=re.compile("Via 1 to .* m above home")).click()
    proved(page)
    assert page.locator(".map").bounding_box() == before
    assert page.locator(".lit").count() == 0


def test_a_fence_that_is_refused_is_drawn_all_the_same(page: Any) -> None:
    proved(page)
    ring = "[[50.0, 20.0], [90.0, 20.0], [90.0, 60.0], [50.0, 60.0]]"
    rewrite(page, MEADOW.read_text() + f"\n[[fence]]\npolygon = {ring}\n")
    page.get_by_text("expected home inside of it").wait_for()
    drawn = "window.map.querySourceFeatures('fences').length"
    until(page, f"{drawn} > 0")
    page.get_by_role("button", name="Undo").first.click()
    until(page, f"{drawn} === 0")


def test_a_height_is_changed_for_all_at_once(page: Any) -> None:
    field = page.get_by_label("Height of all places")
    field.fill("14")
    field.press("Tab")
    until(page, "document.querySelector('textarea').value.split('height_above_ground = 14').length === 3")
    page.get_by_role("button", name="Undo").click()
    until(page, "!document.querySelector('textarea').value.includes('height_above_ground')")


def test_the_arrow_keys_move_what_is_focused(page: Any) -> None:
    page.locator("[data-spot=goal]").focus()
    page.keyboard.press("Shift+ArrowUp")
    until(page, "document.querySelector('textarea').value.includes('north = 10.0')")


def test_a_place_is_found_by_its_coordinates_and_the_ground_is_shaded(page: Any) -> None:
    proved(page)
    field = page.get_by_label("Go to a place")
    field.fill("47.31 N, 8.52 E")
    field.press("Enter")
    page.get_by_text("47.310000, 8.520000, ").wait_for()
    until(page, "map.getCenter().lng.toFixed(4) === '8.5200' && map.querySourceFeatures('found').length > 0")
    field.fill("nowhere")
    field.press("Enter")
    page.get_by_text("expected degrees").wait_for()
    page.get_by_label("Forget the place").click()
    assert page.evaluate("map.getLayer('hillshade') === undefined")  # level ground has no shadow
    hill = 'kind = "grid"\neast = -200.0\nnorth = -200.0\nspacing = 400.0\nheights = [[0.0, 0.0], [8.0, 8.0]]'
    rewrite(page, f"{MEADOW.read_text()}\n[terrain]\n{hill}\n")
    until(page, "map.getLayer('hillshade') !== undefined")
    page.keyboard.press("Home")


#: Too high to land on.
SHED = """
[[obstacles]]
kind = "box"
name = "shed"
east = 52.0
north = 0.0
width = 6.0
depth = 12.0
height = 4.0
"""


def test_the_strip_says_what_each_contingency_would_do_at_this_second(page: Any, address: tuple[str, Path]) -> None:
    proved(page)
    text = MEADOW.read_text() + BATTERY + SHED
    rewrite(page, text)
    page.get_by_label("Moment of the flight").fill("250")
    until(page, "/lands with .* required/.test(document.querySelector('.strip .then')?.textContent)")
    page.get_by_role("button", name="Mission files").click()
    page.get_by_text("written: meadow.plan").wait_for()
    scenario = parse_scenario(text, address[1])
    contingencies = Contingencies(Forecast(read_mission(address[1].parent / "meadow.plan"), scenario))
    moment, then = page.get_by_label("Moment of the flight"), page.locator(".strip .then")
    for at in (120, 250, 380):
        moment.fill(str(at))
        until(page, f"document.querySelector('.strip .row').ariaValueNow === '{at}'")
        time = float(page.locator(".slider output").inner_text().split(" s")[0])
        for contingency in contingencies_of(contingencies.forecast):
            described = page.locator(f".strip [data-contingency={contingency}]").get_attribute("aria-valuetext")
            row = next(row for row in contingencies.rows(contingency, timed=False) if time < row.to_s)
            assert described.startswith(f"at {time:.1f} s {row.in_full}")
            taken = re.search(r"; takes (\d+)(?: to (\d+))? s and [\d.]+ to [\d.]+ Wh, lands with [\d.]+ %", described)
            assert (taken is None) == (contingency in (Contingency.SMART_RTL, Contingency.HOLD))
            if taken:
                predicted = contingencies.predicted(contingency, time)
                assert predicted is not None
                seconds = float(taken[1]), float(taken[2] or taken[1])
                assert seconds == pytest.approx(predicted.duration_s, rel=0.1, abs=2.0)
    land, ways = page.locator(".strip [data-contingency=land]"), page.locator(".strip [data-contingency=land] .ways")
    land.focus()
    assert then.inner_text() == f"land {land.get_attribute('aria-valuetext')}"
    page.keyboard.press("Home")
    until(page, "document.querySelector('.strip .then').textContent.endsWith('it is on the ground')")
    rows = contingencies.rows(Contingency.LAND, timed=False)
    assert Grade.UNCLEAR in {row.grade for row in rows}
    for row in rows:  # a key leads to it, and on to its changes
        page.keyboard.press("PageUp")
        until(page, f"document.querySelector('.strip .then').textContent.includes({json.dumps(row.in_full)})")
    looks = page.locator(".strip [data-contingency=land] .way").evaluate_all("ways => ways.map(way => way.textContent)")
    assert looks == [GRADE_LOOKS[row.grade] for row in rows]
    Hand(page).settle()
    box = ways.bounding_box()
    page.mouse.move(box["x"] + 0.25 * box["width"], box["y"] + box["height"] / 2)
    until(page, "document.querySelector('.strip .then').textContent.startsWith('land at')")
    pointed = then.inner_text()
    assert pointed != f"land {land.get_attribute('aria-valuetext')}"  # the slider stands where it stood
    page.mouse.down()
    page.mouse.up()
    until(page, f"document.querySelector('.strip [data-contingency=land]').ariaValueText === {json.dumps(pointed[5:])}")


def test_page_fits_a_telephone(page: Any) -> None:
    page.set_viewport_size({"width": 390, "height": 844})
    proved(page)
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    assert page.locator(".map").bounding_box()["height"] > 250
    assert page.locator(".bar").bounding_box()["height"] < 100  # its tools are one row, which scrolls


def test_findings_remain_on_paper_and_tools_do_not(page: Any) -> None:
    proved(page)
    page.emulate_media(media="print")
    assert page.locator(".verdict").get_by_text("m required").first.is_visible()
    assert page.locator(".bindings button").first.is_visible()
    page.set_viewport_size({"width": 700, "height": 1000})  # paper is as narrow as a telephone
    for name in ("Save", "whole screen"):
        assert not page.get_by_role("button", name=name).is_visible()
    fields = "[...document.querySelectorAll('input, select, textarea')]"
    assert not page.evaluate(f"{fields}.some(one => one.checkVisibility())")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_page_has_no_serious_fault_of_accessibility(page: Any, scheme: str) -> None:
    proved(page)
    page.locator(".strip .way").first.wait_for()
    assert serious(page, scheme) == []
