"""Who signs what we say: a key in a file, or a passphrase in the environment, which is never printed.

A key is 64 hexadecimal digits, 32 bytes that are no text, or a passphrase without the line end behind it: the same in a
file and in the environment. A signature's timestamps must only grow, from one run to the next: the last is kept in the
user's folder for state.
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
    """Who signs: the key in a file, else the passphrase in the environment, else nobody. Each role has its timestamps.

    Raises:
        BadInput: the key cannot be read, or the folder for state not be made.
    """
    words = os.environ.get(PASSPHRASE)
    if key is None and not words:
        return None
    from ipoa_mission.link.signing import key_of, persistent_signer, read_key

    secret = read_key(key) if key is not None else key_of(words or "")
    folder = state_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    except OSError as error:
        message = f"cannot be made: {error.strerror}"
        raise Unwritable(message, hint="it keeps the timestamps of signing", place=folder) from error
    return persistent_signer(secret, folder / f"signing-{role}.timestamp")


def state_folder() -> Path:
    """Where the user's system wants programs to keep what is neither settings nor documents."""
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local") / "ipoa-mission"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Application Support" / "ipoa-mission"
    return Path(os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state") / "ipoa-mission"
