"""Plan an obstacle-free flight, write it as a QGroundControl mission, upload it and forecast its duration.

    from ipoa_mission import plan_flight, read_scenario

    flight = plan_flight(read_scenario("missions/campus.toml"), seed=7)
    flight.write("out")
    print(flight.estimate.total_s)

Names are imported at first use, so `import ipoa_mission` is quick. docs/api.md lists them all, and `help` explains
each. The modules below are internal and may change with any version.
"""

# No imports here: Ctrl-C during the command line's imports is caught in `__main__`, which runs after this.
_WHERE: dict[str, str] = {}


def _where() -> dict[str, str]:
    if not _WHERE:
        import re
        from pathlib import Path

        stub = Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8")
        names = re.findall(r"^from (ipoa_mission\S*) import (\w+)", stub, re.MULTILINE)
        _WHERE.update({name: module for module, name in names})
    return _WHERE


def __getattr__(name: str) -> object:
    from importlib import import_module

    if name == "__version__":
        return import_module("importlib.metadata").version("ipoa-mission")
    if name == "__all__":
        return sorted(_where())
    if name in _where():
        return getattr(import_module(_where()[name]), name)
    raise AttributeError(f"module 'ipoa_mission' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(_where())
