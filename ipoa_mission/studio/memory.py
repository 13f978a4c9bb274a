"""Remember addresses, recent files and map tiles in `studio.json` of the state folder."""

import secrets
from contextlib import suppress
from pathlib import Path
from typing import Annotated

from pydantic import BaseModel, Field

from ipoa_mission.files import write_atomically
from ipoa_mission.options import state_folder


class Opened(BaseModel, frozen=True):
    """A file once open, "" for the start page; `world` and `log` of a mission."""

    path: str
    port: int
    token: Annotated[str, Field(pattern="^[!-~]{21,}$")]
    world: str = ""
    log: str = ""


class Memory(BaseModel, frozen=True):
    """`opened`: the latest first. `tiles`: source and attribution."""

    opened: tuple[Opened, ...] = ()
    tiles: tuple[str, str] | None = None


def memory_file() -> Path:
    return state_folder() / "studio.json"


def known() -> Memory:
    with suppress(OSError, ValueError):
        return Memory.model_validate_json(memory_file().read_bytes())
    return Memory()


def address_of(path: Path | None) -> Opened:
    """Return a file's last address, else port 0 and a new token; None: the start page."""
    name = "" if path is None else str(path)
    before = next((file for file in known().opened if file.path == name), None)
    return before or Opened(path=name, port=0, token=secrets.token_urlsafe(24))


def remember(opened: Opened, port: int) -> None:
    others = [file for file in known().opened if file.path != opened.path]
    keep(opened=(opened.model_copy(update={"port": port}), *others)[:20])


def keep(**changes: object) -> None:
    """Replace fields; ignore a file that cannot be written."""
    file = memory_file()
    with suppress(OSError):
        file.parent.mkdir(parents=True, exist_ok=True)
        file.parent.chmod(0o700)
        write_atomically(file, known().model_copy(update=changes).model_dump_json(indent=1) + "\n")
        file.chmod(0o600)
