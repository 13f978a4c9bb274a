"""What hatchling asks when it builds: machine code for a wheel, and the studio's page if that is wished."""

import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

#: What the kernels' modules import, besides numba.
NEEDED = ("numpy", "scipy", "pydantic", "pyproj", "shapely")
MESSAGES = "pymavlink>=2.4.47"  # the table that is made of it
NUMBA = "numba>=0.60"


class Built(BuildHookInterface):  # type: ignore[misc]
    """Compiles the kernels once, for everyone who installs the wheel (see `ipoa_mission.compiled`)."""

    def dependencies(self) -> list[str]:
        """What compiles: numba, what the kernels import, `ziglang` where there is no C compiler; and pymavlink."""
        if self.target_name == "sdist":
            return []
        here = [name for name in self.metadata.core.dependencies if name.startswith(NEEDED)]
        linker = [] if any(map(shutil.which, ("cc", "gcc", "clang"))) else ["ziglang"]
        return [*here, MESSAGES, NUMBA, *linker]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """A wheel gets the libraries, an editable install beside its sources; a source distribution what git knows."""
        if self.target_name == "sdist":
            self._leave_out_untracked()
            return
        self._made = tempfile.TemporaryDirectory()
        root, made = Path(self.root), Path(self._made.name)
        path = os.pathsep.join([str(root), *filter(None, [os.environ.get("PYTHONPATH")])])
        cpus = os.environ.get("IPOA_MISSION_CPUS", "").split()

        def make(module: str, *arguments: str) -> None:
            command = [sys.executable, "-m", module, str(made), *arguments]
            subprocess.run(command, check=True, cwd=root, env=os.environ | {"PYTHONPATH": path})

        make("tools.generate.message_table")
        try:
            make("tools.machine_code", *cpus)
            is_native = True
        except subprocess.CalledProcessError:  # as where this system's linker does not know what the kernels call
            self.app.display_warning("no machine code could be made here: numba will compile at the first plan")
            build_data["dependencies"].append(NUMBA)
            for part in made.glob("kernels*"):
                part.unlink()
            is_native = False
        for file in made.iterdir():
            room = "link" if file.name == "messages.json" else "compiled"
            if version == "editable":
                shutil.copy(file, root / "ipoa_mission" / room / file.name)
            else:
                build_data["force_include"][str(file)] = f"ipoa_mission/{room}/{file.name}"
        if os.environ.get("IPOA_MISSION_STUDIO") == "1":  # who does not want the studio needs no npm
            for step in (["ci", "--no-audit", "--no-fund"], ["run", "build"]):
                subprocess.run(["npm", *step], check=True, cwd=root / "ipoa_mission" / "studio" / "web")
        build_data["pure_python"] = version == "editable" or not is_native
        if not build_data["pure_python"]:
            system = sysconfig.get_platform().replace("-", "_").replace(".", "_")
            build_data["tag"] = f"py3-none-{system}"

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Clean up."""
        if self.target_name == "wheel":
            self._made.cleanup()

    def _leave_out_untracked(self) -> None:
        command = ["git", "ls-files", "--others", "--exclude-standard", "-z"]
        untracked = subprocess.run(command, cwd=self.root, capture_output=True, text=True, check=False).stdout
        given = self.build_config.target_config.setdefault("exclude", [])
        given += ["/" + re.sub(r"[][*?!\\]", r"\\\g<0>", name) for name in untracked.split("\0") if name]
