"""The picture of a survey in docs/studio.md: that of docs/how-to/survey.md, by a camera, its second flight shown.

    python -m tools.generate.survey_picture docs/pictures

Needs playwright and Chromium, which draws by software.
"""

import re
import shutil
import tempfile
from pathlib import Path

from playwright.sync_api import sync_playwright

from tools import command_line
from tools.generate.studio_pictures import PATIENCE_MS, SOFTWARE, picture, studio

HOW_TO = Path("docs/how-to/survey.md")
CAMERA = 'camera = "DJI Mavic 3E"\nfront_overlap = 0.75\nside_overlap = 0.65'


def scenario_of(how_to: str) -> str:
    """The scenario that the page has, seen by a camera in place of lines at a distance."""
    found = re.search(r"cat > field\.toml <<'END'\n(.*?)\nEND\n", how_to, re.DOTALL)
    assert found is not None
    return re.sub(r"^line_spacing = .*$", CAMERA, found[1], flags=re.MULTILINE)


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("out", type=Path)
    out = parser.parse_args().out
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as play:
        scenario = Path(folder) / "field.toml"
        scenario.write_text(scenario_of(HOW_TO.read_text(encoding="utf-8")), encoding="utf-8")
        browser = play.chromium.launch(executable_path=shutil.which("chromium"), args=SOFTWARE)
        with studio(scenario, Path(folder)) as address:
            page = browser.new_page(viewport={"width": 1280, "height": 800})
            page.set_default_timeout(PATIENCE_MS)
            page.goto(address)
            page.get_by_role("button", name="field-2.plan").click()
            page.get_by_label("Moment of the flight").fill("330")
            picture(page, out / "studio-survey.png")
        browser.close()


if __name__ == "__main__":
    main()
