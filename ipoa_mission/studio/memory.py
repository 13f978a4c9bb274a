"""Remember addresses, recent files and map tiles in `$XDG_STATE_HOME/ipoa-mission/studio.json`.

Without the variable below `~/.local/state` or `%LOCALAPPDATA%`. It can be deleted at any time.
"""

import json
import os
import secrets
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from ipoa_mission.files import write_atomically


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
    opened = []
    for entry in _read().get("opened", ()):
        with suppress(AttributeError, KeyError, TypeError, ValueError):
            about = (str(entry.get(key, "")) for key in ("world", "log"))
            opened.append(Opened(str(entry["path"]), int(entry["port"]), str(entry["token"]), *about))
    return [file for file in opened if file.token.isascii() and len(file.token) > 20]


def address_of(path: Path | None) -> Opened:
    """Return a file's last address, else port 0 and a new token; None: the start page."""
    name = "" if path is None else str(path)
    known = next((file for file in recent() if file.path == name), None)
    return known or Opened(name, 0, secrets.token_urlsafe(24))


def remember(opened: Opened, port: int) -> None:
    others = [asdict(file) for file in recent() if file.path != opened.path]
    _write({"opened": [asdict(replace(opened, port=port)), *others][:20]})


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
    with suppress(OSError):
        file.parent.mkdir(parents=True, exist_ok=True)
        file.parent.chmod(0o700)
        write_atomically(file, json.dumps(_read() | changes, indent=1) + "\n")
        file.chmod(0o600)
