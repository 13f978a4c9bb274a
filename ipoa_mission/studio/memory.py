"""Remember addresses, recent files and map tiles in `$XDG_STATE_HOME/ipoa-mission/studio.json`.

Without the variable below `~/.local/state` or `%LOCALAPPDATA%`. It can be deleted at any time.
"""

import json
import os
import secrets
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from ipoa_mission.files import write_atomically

FILE_LIMIT = 20


@dataclass(frozen=True)
class Opened:
    """A file once open, "" for the start page; `world` and `log` of a mission."""

    path: str
    port: int
    token: str
    world: str = ""
    log: str = ""


def memory_file() -> Path:
    base = os.environ.get("XDG_STATE_HOME") or os.environ.get("LOCALAPPDATA") or Path.home() / ".local" / "state"
    return Path(base) / "ipoa-mission" / "studio.json"


def recent() -> list[Opened]:
    found = []
    for entry in _read().get("opened", ()):
        try:
            about = (str(entry.get(key, "")) for key in ("world", "log"))
            found.append(Opened(str(entry["path"]), int(entry["port"]), str(entry["token"]), *about))
        except (AttributeError, KeyError, TypeError, ValueError):
            continue
    return [one for one in found if one.token.isascii() and len(one.token) > 20]


def address_of(path: Path | None) -> Opened:
    """Return a file's last address, else port 0 and a new token; None: the start page."""
    name = "" if path is None else str(path)
    known = next((one for one in recent() if one.path == name), None)
    return known or Opened(name, 0, secrets.token_urlsafe(24))


def remember(opened: Opened, port: int) -> None:
    others = [asdict(one) for one in recent() if one.path != opened.path]
    _write({"opened": [asdict(replace(opened, port=port)), *others][:FILE_LIMIT]})


def kept_tiles() -> tuple[str, str] | None:
    known = _read().get("tiles")
    return (str(known[0]), str(known[1])) if isinstance(known, list) and len(known) == 2 else None


def keep_tiles(tiles: tuple[str, str] | None) -> None:
    _write({"tiles": tiles})


def _read() -> dict[str, Any]:
    try:
        known = json.loads(memory_file().read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return known if isinstance(known, dict) else {}


def _write(changes: dict[str, Any]) -> None:
    """Replace entries; ignore a file that cannot be written."""
    file = memory_file()
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.parent.chmod(0o700)
        write_atomically(file, json.dumps(_read() | changes, indent=1) + "\n")
        file.chmod(0o600)
    except OSError:
        return
