"""Look at a report as people will: screenshots at the widths of a desk and a telephone, light and dark.

    python -m tools.generate.screenshot report.html out/

Needs playwright and Chromium (`apt install chromium`; IPOA_MISSION_CHROMIUM may name another). Prints when the page
was there, and every complaint of the browser.
"""

import os
from pathlib import Path

from playwright.sync_api import sync_playwright

from tools import command_line

WIDTHS = (1280, 390)


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("report", type=Path)
    parser.add_argument("out", type=Path)
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    with sync_playwright() as play:
        browser = play.chromium.launch(
            executable_path=os.environ.get("IPOA_MISSION_CHROMIUM", "/usr/bin/chromium"), args=["--no-sandbox"]
        )
        for scheme in ("light", "dark"):
            for width in WIDTHS:
                page = browser.new_page(viewport={"width": width, "height": 900}, color_scheme=scheme)
                page.on("console", lambda message: print(f"console: {message.text}"))
                page.on("pageerror", lambda error: print(f"error: {error}"))
                page.goto(arguments.report.resolve().as_uri())
                page.wait_for_function("document.querySelector('.space canvas').dataset.heading !== undefined")
                drawn = page.evaluate("performance.now()")
                page.wait_for_timeout(300)
                painted = page.evaluate("performance.getEntriesByType('paint').at(-1).startTime")
                picture = arguments.out / f"{arguments.report.stem}-{width}-{scheme}.png"
                page.screenshot(path=picture, full_page=True)
                print(f"{picture}: first paint after {painted:.0f} ms, 3D view after {drawn:.0f} ms")
        browser.close()


if __name__ == "__main__":
    main()
