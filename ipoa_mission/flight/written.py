"""Which of the files that a plan would write are there and are nobody's plan, or were changed since."""

import json
from hashlib import sha256
from pathlib import Path

from ipoa_mission.errors import BadInput
from ipoa_mission.files import read_text

PAGE_MARK = '<meta name="generator" content="ipoa-mission">'


def digest(text: str) -> str:
    """What NAME.json remembers of a file that was written with it."""
    return sha256(text.encode()).hexdigest()


def not_as_written(folder: Path, name: str, report: bool = False) -> list[Path]:
    """NAME.plan, NAME.waypoints, NAME.json (and the page, NAME.html) that `Flight.write` did not leave like this."""
    about = folder / f"{name}.json"
    known = _digests(about)
    missions = (folder / f"{name}{suffix}" for suffix in (".plan", ".waypoints"))
    others = [path for path in missions if path.exists() and digest(_text(path)) != known.get(path.name)]
    if about.exists() and not known:
        others.append(about)
    page = folder / f"{name}.html"
    if report and page.exists() and PAGE_MARK not in _text(page):
        others.append(page)
    return others


def _digests(about: Path) -> dict[str, str]:
    try:
        told = json.loads(_text(about))
    except ValueError:
        return {}
    digests = told.get("sha256") if isinstance(told, dict) else None
    return digests if isinstance(digests, dict) else {}


def _text(path: Path) -> str:
    try:
        return read_text(path)
    except BadInput:
        return ""
