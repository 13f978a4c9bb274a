"""`demo`: the main job on a scenario that is packed with the program."""

from pathlib import Path

from ipoa_mission.cli.groups import FaultOptions, FlownByOptions, LinkOptions, SearchOptions
from ipoa_mission.cli.options import ForceOption, JsonOption, OutOption, SeedOption


def demo(
    out: OutOption = Path("demo"), seed: SeedOption = 0, force: ForceOption = False, as_json: JsonOption = False
) -> None:
    """Plan a flight over a campus, write its files, upload it to the built-in autopilot, fly it, report.

    The files go to the folder `demo`: campus.plan for QGroundControl, campus.html for a browser. It is
    `ipoa-mission fly campus --out demo --report`.

    Example: `ipoa-mission demo`
    """
    from ipoa_mission.cli.flying import fly
    from ipoa_mission.cli.packed import NAMES, or_packed

    ways = SearchOptions(seed=seed), FlownByOptions(), LinkOptions(), FaultOptions()
    fly(or_packed(Path(NAMES[0])), *ways, out=out, report=True, force=force, as_json=as_json)
