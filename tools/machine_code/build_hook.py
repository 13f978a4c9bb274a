"""What hatchling asks when it builds: machine code for a wheel, and only what git knows for a source distribution."""

import os
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


class MachineCode(BuildHookInterface):  # type: ignore[misc]
    """Compiles the kernels once, for everyone who installs the wheel (see `ipoa_mission.compiled`)."""

    def dependencies(self) -> list[str]:
        """What compiles: numba, what the kernels' modules import, and `ziglang` where there is no C compiler."""
        here = [name for name in self.metadata.core.dependencies if name.startswith(NEEDED)]
        return [*here, "numba>=0.60", *([] if any(map(shutil.which, ("cc", "gcc", "clang"))) else ["ziglang"])]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Make the libraries: beside the sources for an editable install, else where only the wheel takes them."""
        self._made = tempfile.TemporaryDirectory()
        root, made = Path(self.root), Path(self._made.name)
        path = os.pathsep.join([str(root), *filter(None, [os.environ.get("PYTHONPATH")])])
        subprocess.run(
            [sys.executable, "-m", "tools.machine_code", str(made), *os.environ.get("IPOA_MISSION_CPUS", "").split()],
            check=True, cwd=root, env=os.environ | {"PYTHONPATH": path},
        )  # fmt: skip
        for file in made.iterdir():
            if version == "editable":
                shutil.copy(file, root / "ipoa_mission" / "compiled" / file.name)
            else:
                build_data["force_include"][str(file)] = f"ipoa_mission/compiled/{file.name}"
        build_data["pure_python"] = version == "editable"
        if version != "editable":
            system = sysconfig.get_platform().replace("-", "_").replace(".", "_")
            build_data["tag"] = f"py3-none-{system}"

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Clean up."""
        self._made.cleanup()
