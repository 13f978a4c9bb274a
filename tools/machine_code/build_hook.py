"""Hook into hatchling's build: machine code for a wheel, and the studio's page for a wheel and an sdist.

Both also stay next to the sources, ignored by git: a clone runs from its own folder, and the next build of the same
sources takes them from there.
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

#: Imports of the kernels' modules, in addition to numba.
NEEDED = ("numpy", "pyproj", "shapely")
NUMBA = "numba>=0.60"
WEB = Path("ipoa_mission", "studio", "web")
NO_PAGE = "IPOA_MISSION_NO_PAGE"  # if set, the studio's page is not built


class Built(BuildHookInterface):  # type: ignore[misc]
    """Compile the kernels and bundle the page once for all installs of the build."""

    def dependencies(self) -> list[str]:
        """Return the build requirements: numba, the kernels' imports, `ziglang` without a C compiler."""
        if self.target_name == "sdist":
            return []
        here = [name for name in self.metadata.core.dependencies if name.startswith(NEEDED)]
        linker = [] if any(map(shutil.which, ("cc", "gcc", "clang"))) else ["ziglang"]
        return [*here, NUMBA, *linker]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Add libraries and page to a wheel or, for an editable install, to its sources; an sdist has git's files."""
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
            with suppress(OSError):  # read-only folder
                shutil.copy(file, beside)
            if version != "editable":
                build_data["force_include"][str(file)] = f"ipoa_mission/compiled/{file.name}"
        build_data["pure_python"] = version == "editable" or not is_native
        if not build_data["pure_python"]:
            system = sysconfig.get_platform().replace("-", "_").replace(".", "_")
            build_data["tag"] = f"py3-none-{system}"

    def _compile(self, folder: Path) -> bool:
        """Make the libraries and their index; return whether this was possible."""
        path = os.pathsep.join([self.root, *filter(None, [os.environ.get("PYTHONPATH")])])
        cpus = os.environ.get("IPOA_MISSION_CPUS", "").split()
        command = [sys.executable, "-m", "tools.machine_code", str(folder), *cpus]
        try:
            subprocess.run(command, check=True, cwd=self.root, env=os.environ | {"PYTHONPATH": path})
        except subprocess.CalledProcessError:  # e.g. this system's linker does not know what the kernels call
            self.app.display_warning("no machine code could be made here: numba will compile at the first plan")
            for part in folder.glob("kernels*"):
                part.unlink()
            return False
        return True

    def _build_page(self) -> None:
        """Bundle the page unless it is up to date; without npm the build has no page, and says so."""
        sys.path.insert(0, self.root)
        from ipoa_mission.errors import MissionError
        from ipoa_mission.studio import bundle

        web = Path(self.root) / WEB
        if NO_PAGE in os.environ or bundle.has_page(web):
            return
        try:
            bundle.build_page(web, self.app.display_info)
        except (MissionError, OSError) as error:
            self.app.display_warning(f"without the studio's page, which is built when it is first opened: {error}")

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        if self.target_name == "wheel":
            self._made.cleanup()

    def _leave_out_untracked(self) -> None:
        command = ["git", "ls-files", "--others", "--exclude-standard", "-z"]
        untracked = subprocess.run(command, cwd=self.root, capture_output=True, text=True, check=False).stdout
        given = self.build_config.target_config.setdefault("exclude", [])
        given += ["/" + re.sub(r"[][*?!\\]", r"\\\g<0>", name) for name in untracked.split("\0") if name]
