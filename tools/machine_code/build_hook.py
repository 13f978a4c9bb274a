"""What hatchling asks when it builds: machine code for a wheel, and the studio's page for a wheel and an sdist.

Both are also left beside the sources, where git does not see them: a clone runs from its own folder then, and the next
build of the same sources takes them from there.
"""

import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

#: What the kernels' modules import, besides numba.
NEEDED = ("numpy", "pyproj", "shapely")
NUMBA = "numba>=0.60"
WEB = Path("ipoa_mission", "studio", "web")
NO_PAGE = "IPOA_MISSION_NO_PAGE"  # set to anything: the studio's page is not built


class Built(BuildHookInterface):  # type: ignore[misc]
    """Compiles the kernels and bundles the page once, for everyone who installs what is built."""

    def dependencies(self) -> list[str]:
        """What compiles: numba, what the kernels import, `ziglang` where there is no C compiler."""
        if self.target_name == "sdist":
            return []
        here = [name for name in self.metadata.core.dependencies if name.startswith(NEEDED)]
        linker = [] if any(map(shutil.which, ("cc", "gcc", "clang"))) else ["ziglang"]
        return [*here, NUMBA, *linker]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """A wheel gets libraries and page, an editable install both beside its sources; an sdist what git knows."""
        self._build_page()
        if self.target_name == "sdist":
            self._leave_out_untracked()
            return
        self._made = tempfile.TemporaryDirectory()
        is_native = self._compile(Path(self._made.name))
        if not is_native:
            build_data["dependencies"].append(NUMBA)
        for file in Path(self._made.name).iterdir():
            beside = Path(self.root, "ipoa_mission", "compiled", file.name)
            with suppress(OSError):  # a folder in which nobody may write
                shutil.copy(file, beside)
            if version != "editable":
                build_data["force_include"][str(file)] = f"ipoa_mission/compiled/{file.name}"
        build_data["pure_python"] = version == "editable" or not is_native
        if not build_data["pure_python"]:
            system = sysconfig.get_platform().replace("-", "_").replace(".", "_")
            build_data["tag"] = f"py3-none-{system}"

    def _compile(self, folder: Path) -> bool:
        """Make the libraries and their index; whether that could be done here."""
        path = os.pathsep.join([self.root, *filter(None, [os.environ.get("PYTHONPATH")])])
        cpus = os.environ.get("IPOA_MISSION_CPUS", "").split()
        command = [sys.executable, "-m", "tools.machine_code", str(folder), *cpus]
        try:
            subprocess.run(command, check=True, cwd=self.root, env=os.environ | {"PYTHONPATH": path})
        except subprocess.CalledProcessError:  # as where this system's linker does not know what the kernels call
            self.app.display_warning("no machine code could be made here: numba will compile at the first plan")
            for part in folder.glob("kernels*"):
                part.unlink()
            return False
        return True

    def _build_page(self) -> None:
        """Bundle the page, unless that of these sources is there; without npm what is built has none, and says so."""
        sys.path.insert(0, self.root)
        from ipoa_mission.errors import MissionError
        from ipoa_mission.studio import bundle

        web = Path(self.root) / WEB
        if NO_PAGE in os.environ or bundle.has_page(web):
            return
        try:
            bundle.build_page(web, web / "dist", self.app.display_info)
        except (MissionError, OSError) as error:
            self.app.display_warning(f"without the studio's page, which is built when it is first opened: {error}")

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Clean up."""
        if self.target_name == "wheel":
            self._made.cleanup()

    def _leave_out_untracked(self) -> None:
        command = ["git", "ls-files", "--others", "--exclude-standard", "-z"]
        untracked = subprocess.run(command, cwd=self.root, capture_output=True, text=True, check=False).stdout
        given = self.build_config.target_config.setdefault("exclude", [])
        given += ["/" + re.sub(r"[][*?!\\]", r"\\\g<0>", name) for name in untracked.split("\0") if name]
