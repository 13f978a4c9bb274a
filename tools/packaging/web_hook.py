"""The studio's page in a wheel: what was built lies in it; with IPOA_MISSION_STUDIO=1 it is built now, by npm.

Who installs from source and does not want the studio waits for nothing: the wheel is made without the page, and
`ipoa-mission studio` builds it when it is first asked for.
"""

import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

WEB = Path("ipoa_mission", "studio", "web")


class WebHook(BuildHookInterface):  # type: ignore[misc]
    """Hatchling's hook; another hook may call `include_page` in its place."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Before a wheel is made."""
        if version == "standard":
            include_page(Path(self.root), build_data)


def include_page(root: Path, build_data: dict[str, Any]) -> None:
    """Put the built page into a wheel, if there is one."""
    npm = shutil.which("npm")
    if os.environ.get("IPOA_MISSION_STUDIO") == "1" and npm is not None:
        for step in (["ci", "--no-audit", "--no-fund"], ["run", "build"]):
            subprocess.run([npm, *step], cwd=root / WEB, check=True)
    if (root / WEB / "dist" / "index.html").is_file():
        build_data["force_include"][str(root / WEB / "dist")] = (WEB / "dist").as_posix()
