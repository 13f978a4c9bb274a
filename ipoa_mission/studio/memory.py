"""What the studio knows from the last time: the address it had for a file, which files were open, the map tiles.

One JSON file of this user's, in a folder that nobody else may enter: `$XDG_STATE_HOME/ipoa-mission/studio.json`, else
below `~/.local/state`; below `%LOCALAPPDATA%` on Windows. Who deletes it loses no more than that.
"""

import json
import os
import secrets
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from ipoa_mission.files import write_atomically

KEPT = 20  # files that are remembered


@dataclass(frozen=True)
class Opened:
    """A file that was open, and the port and the token of its page's address; "" is the start page.

    `world` and `log`: the scenario and the log beside which a mission was open.
    """

    path: str
    port: int
    token: str
    world: str = ""
    log: str = ""


def memory_file() -> Path:
    """Where it is kept."""
    base = os.environ.get("XDG_STATE_HOME") or os.environ.get("LOCALAPPDATA") or Path.home() / ".local" / "state"
    return Path(base) / "ipoa-mission" / "studio.json"


def recent() -> list[Opened]:
    """The files that were open, the last one first."""
    found = []
    for entry in _read().get("opened", ()):
        try:
            about = (str(entry.get(key, "")) for key in ("world", "log"))
            found.append(Opened(str(entry["path"]), int(entry["port"]), str(entry["token"]), *about))
        except (AttributeError, KeyError, TypeError, ValueError):
            continue
    return [one for one in found if one.token.isascii() and len(one.token) > 20]


def address_of(path: Path | None) -> Opened:
    """The address that this file had, with port 0 and a new token if it had none; None: that of the start page."""
    name = "" if path is None else str(path)
    known = next((one for one in recent() if one.path == name), None)
    return known or Opened(name, 0, secrets.token_urlsafe(24))


def remember(opened: Opened, port: int) -> None:
    """That this file is open at a port."""
    others = [asdict(one) for one in recent() if one.path != opened.path]
    _write({"opened": [asdict(replace(opened, port=port)), *others][:KEPT]})


def kept_tiles() -> tuple[str, str] | None:
    """The map tiles of the last time: their source, and whose they are."""
    known = _read().get("tiles")
    return (str(known[0]), str(known[1])) if isinstance(known, list) and len(known) == 2 else None


def keep_tiles(tiles: tuple[str, str] | None) -> None:
    """Remember map tiles, or none."""
    _write({"tiles": tiles})


def _read() -> dict[str, Any]:
    try:
        known = json.loads(memory_file().read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return known if isinstance(known, dict) else {}


def _write(changes: dict[str, Any]) -> None:
    """Keep some of it anew; where nothing can be written nothing is remembered."""
    file = memory_file()
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.parent.chmod(0o700)
        write_atomically(file, json.dumps(_read() | changes, indent=1) + "\n")
        file.chmod(0o600)
    except OSError:
        return
