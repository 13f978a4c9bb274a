from pathlib import Path
from typing import Any

from ipoa_mission.scenario import read_scenario
from ipoa_mission.survey.survey_section import survey_of
from tests.studio import chromium as own
from tests.studio.chromium import address, browser, own_page, pytestmark, until
from tests.studio.pointing import Hand, middle_of

__all__ = ["address", "browser", "own_page", "pytestmark"]


def planned(page: Any, flights: int) -> None:
    page.locator(f".flights:not(.stale) tbody tr:nth-child({flights})").wait_for()
    page.locator(".verdict :is(.good, .amber)").first.wait_for()


def dragged(page: Any, grip: str, right: float, down: float) -> None:
    """Drag a handle; meanwhile nothing looks proved."""

    def look() -> None:
        page.get_by_text("While you drag").wait_for()
        assert page.locator(".verdict :is(.good, .amber)").count() == 0

    Hand(page).drag(middle_of(f"[data-grip='{grip}']"), right, down, look)


def test_an_area_is_drawn_bent_turned_split_and_flown(own_page: Any, address: tuple[str, Path]) -> None:
    page = own_page
    own.proved(page)
    page.locator("summary", has_text="Survey").click()
    page.get_by_role("button", name="Draw an area …").click()
    for place in own.places(page, (-0.2, -0.25), (0.4, -0.25), (0.4, 0.15), (-0.2, 0.15)):
        page.mouse.click(*place)
    page.keyboard.press("Enter")
    page.get_by_role("button", name="Bounds that hold the survey").click()  # it is flown higher than the meadow's
    planned(page, 1)
    before = page.locator(".map").bounding_box()
    dragged(page, "survey.polygon.0.0.2", 40, -30)
    until(page, "document.querySelector('[title^=Undo]').title.includes('corner moved')")
    dragged(page, "survey direction", -60, -60)
    until(page, "document.querySelector('textarea').value.includes('direction_deg')")
    page.locator("[data-grip='survey direction']").focus()
    page.keyboard.press("Shift+ArrowRight")
    until(page, "document.querySelector('[title^=Undo]').title.includes('lines at')")
    page.keyboard.press("h")
    x, y = Hand(page).at(middle_of("[data-grip='survey middle']"))
    for right, down in ((-48, 42), (-8, 42), (-8, 72)):
        page.mouse.click(x + right, y + down)
    page.keyboard.press("Enter")
    page.get_by_role("button", name="Take hole 1 out").wait_for()
    page.get_by_label("Number of flights").fill("2")
    page.get_by_label("Number of flights").press("Tab")
    planned(page, 2)
    assert page.locator(".map").bounding_box() == before
    page.get_by_role("button", name="meadow-2.plan").click()
    until(page, "document.querySelectorAll('.flights tr.chosen')[0].innerText.includes('meadow-2')")
    page.get_by_role("button", name="Mission files").click()
    page.get_by_text("written: meadow-1.plan").wait_for()
    page.keyboard.press("Control+s")
    page.locator(".saved").wait_for()
    survey = survey_of(read_scenario(address[1]))
    assert survey is not None
    assert survey.flights == 2
    page.locator("summary", has_text="Fly it").click()
    page.get_by_label("Speed-up").fill("200")
    page.get_by_role("button", name="Take meadow-1").click()
    page.get_by_role("button", name="Upload").click()
    page.get_by_role("button", name="Arm and start …").click()
    page.get_by_role("dialog").locator("input").fill("meadow-1")
    page.get_by_role("dialog").get_by_role("button", name="Arm and start").click()
    page.get_by_text("✓ Landed").wait_for()
    page.get_by_role("button", name="Take meadow-2").wait_for()
    page.get_by_label("a vehicle, or SITL").click()
    assert page.get_by_role("button", name="Upload").is_disabled()
    page.get_by_label("a charged battery is in").check()
    assert page.get_by_role("button", name="Upload").is_enabled()
    (log,) = address[1].parent.glob("meadow-1*.tlog")
    page.get_by_label("Was it broken off?").set_input_files(log)
    page.get_by_role("button", name="meadow-rest.plan").wait_for()
    assert page.locator(".flights tbody tr").count() == 1
    page.get_by_role("button", name="Plan all of it again").click()
    planned(page, 2)
    page.get_by_role("button", name="meadow-rest.plan").wait_for(state="detached")
    page.set_viewport_size({"width": 390, "height": 844})
    assert page.evaluate("document.documentElement.scrollWidth") <= 390

    for scheme in ("light", "dark"):
        assert own.serious(page, scheme) == []
