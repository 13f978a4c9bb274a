"""Sign MAVLink with a key from a file, or a passphrase in the environment, never printed.

A key: 64 hexadecimal digits, 32 binary bytes, or a passphrase. The last timestamp is kept: they must grow.
"""

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from ipoa_mission.errors import Unwritable

if TYPE_CHECKING:
    from ipoa_mission.link.signing import Signer

PASSPHRASE = "IPOA_MISSION_PASSPHRASE"


def signer_of(key: Path | None, role: str = "station") -> "Signer | None":
    """Return a signer by the key file, else the environment; each role has own timestamps. Raises BadInput."""
    words = os.environ.get(PASSPHRASE)
    if key is None and not words:
        return None
    from ipoa_mission.link.signing import key_of, persistent_signer, read_key

    secret = read_key(key) if key is not None else key_of(words or "")
    folder = state_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    except OSError as error:
        message = f"cannot be created: {error.strerror}"
        raise Unwritable(message, hint="it holds the timestamps of signatures", place=folder) from error
    return persistent_signer(secret, folder / f"signing-{role}.timestamp")


def state_folder() -> Path:
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local") / "ipoa-mission"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Application Support" / "ipoa-mission"
    return Path(os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state") / "ipoa-mission"
