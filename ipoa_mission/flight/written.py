"""Which of the files that a plan would write are there and are nobody's plan, or were changed since."""

from pathlib import Path

from ipoa_mission.errors import BadInput
from ipoa_mission.files import read_text
from ipoa_mission.mission.about_file import digest, written_with

PAGE_MARK = '<meta name="generator" content="ipoa-mission">'


def not_as_written(folder: Path, name: str, report: bool = False) -> list[Path]:
    """NAME.plan, NAME.waypoints, NAME.json (and the page, NAME.html) that `Flight.write` did not leave like this."""
    about = folder / f"{name}.json"
    digests = written_with(about)
    missions = (folder / f"{name}{suffix}" for suffix in (".plan", ".waypoints"))
    others = [path for path in missions if path.exists() and digest(_text(path)) != digests.get(path.name)]
    if about.exists() and not digests:
        others.append(about)
    page = folder / f"{name}.html"
    if report and page.exists() and PAGE_MARK not in _text(page):
        others.append(page)
    return others


def _text(path: Path) -> str:
    try:
        return read_text(path)
    except BadInput:
        return ""
