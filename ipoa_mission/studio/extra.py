"""What the studio needs beyond the package itself."""

from importlib.util import find_spec

from ipoa_mission.errors import MissionError

LIBRARIES = ("starlette", "uvicorn", "websockets", "tomlkit")


def expect_extra() -> None:
    """Refuse to go on without the libraries.

    Raises:
        MissionError: naming those that are not installed.
    """
    missing = [name for name in LIBRARIES if find_spec(name) is None]
    if missing:
        raise MissionError(f"the studio needs {', '.join(missing)}", hint="pip install 'ipoa-mission[studio]'")
