"""Make the pictures of docs/report.md: plan the campus, report on it, fly it, compare.

    python -m tools.generate.report_pictures

Needs playwright, Pillow and Chromium. The recorded flight is ArduCopter's own, from tests/flights.
"""

import csv
import io
import json
import math
import os
import tempfile
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

from ipoa_mission.autopilot.autopilot import autopilot_named
from ipoa_mission.forecast.forecast import Forecast, estimate
from ipoa_mission.link.logbook import FlightRecord, Sample
from ipoa_mission.mission.mission_io import read_mission
from ipoa_mission.planning.planner import plan_path
from ipoa_mission.report.compare import compare_flight, flown_track
from ipoa_mission.report.comparison_plot import draw_comparison
from ipoa_mission.report.page import write_report
from ipoa_mission.report.plots import draw_views, write_picture
from ipoa_mission.routing.assemble import assemble
from ipoa_mission.scenario import read_scenario
from tools import REPOSITORY, command_line

PICTURES = REPOSITORY / "docs" / "pictures"
FLIGHT = REPOSITORY / "tests" / "flights" / "corners-ardupilot"


def main() -> None:
    command_line(__doc__).parse_args()
    PICTURES.mkdir(exist_ok=True)
    scenario = read_scenario(REPOSITORY / "missions" / "campus.toml")
    plans = {seed: plan_path(scenario, seed=seed) for seed in (1, 2, 3, 7)}
    mission = assemble(plans[7], scenario)
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "campus.html"
        write_report(Forecast(mission, scenario), page, plans[7])
        photograph(page)
    paths = {f"seed {seed}": plans[seed].curve.sample(200) for seed in (1, 2, 3)}
    write_picture(draw_views(scenario, paths), PICTURES / "views.png")
    compare()
    for picture in ("views.png", "comparison.png"):
        save(Image.open(PICTURES / picture), picture)


def photograph(page: Path) -> None:
    """Take screenshots of the page on a desktop (two screens) and on a telephone, in three columns."""
    with sync_playwright() as play:
        browser = play.chromium.launch(
            executable_path=os.environ.get("IPOA_MISSION_CHROMIUM", "/usr/bin/chromium"), args=["--no-sandbox"]
        )
        for width in (1280, 390):
            view = browser.new_page(viewport={"width": width, "height": 900}, color_scheme="light")
            view.goto(page.as_uri())
            view.wait_for_timeout(1500)
            picture = Image.open(io.BytesIO(view.screenshot(full_page=True)))
            if width == 1280:
                save(picture.crop((0, 0, width, 1800)), "report-1280.png")
            else:
                save(columns(picture, 3), "report-390.png")
        browser.close()


def columns(tall: Image.Image, count: int) -> Image.Image:
    """Cut a tall picture into columns."""
    height = math.ceil(tall.height / count)
    sheet = Image.new("RGB", (count * (tall.width + 20) - 20, height), "white")
    for n in range(count):
        part = tall.crop((0, n * height, tall.width, min(tall.height, (n + 1) * height)))
        sheet.paste(part, (n * (tall.width + 20), 0))
    return sheet


def save(picture: Image.Image, name: str) -> None:
    """Save as a small PNG without loss of colors."""
    picture.convert("RGB").save(PICTURES / name, optimize=True)
    print(f"{PICTURES / name}: {(PICTURES / name).stat().st_size // 1024} kB")


def compare() -> None:
    """Compare ArduCopter's flight of the corners with the estimate."""
    facts = json.loads((FLIGHT / "flight.json").read_text())
    mission = read_mission(FLIGHT / "mission.waypoints", autopilot_named(facts["autopilot"]))
    predicted = estimate(mission, facts["params"])
    with (FLIGHT / "trace.csv").open() as file:
        rows = [[float(value) for value in row] for row in list(csv.reader(file))[1:]]
    path = tuple(Sample(r[0], r[1], r[2], math.nan, r[3], math.hypot(*r[4:7])) for r in rows)
    reached = {int(seq) - 1: time for seq, time in facts["item_done_s"].items()}
    flight = FlightRecord(reached, facts["end_s"], path, (), True)
    track = flown_track(mission, flight)
    picture = draw_comparison(
        compare_flight(predicted, flight),
        predicted.track.points,
        None if track is None else track.points,
        f"ArduCopter {facts['version'].split()[0]} against its estimate",
    )
    write_picture(picture, PICTURES / "comparison.png")


if __name__ == "__main__":
    main()
