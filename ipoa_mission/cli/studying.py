"""`studio`: the page on which a flight is drawn, planned, proved, flown and watched."""

import webbrowser
from pathlib import Path
from typing import Annotated

import typer

from ipoa_mission.cli.options import JsonOption, SeedOption, expect_scenario
from ipoa_mission.cli.telling import tell, tell_json


def studio(
    scenario: Annotated[
        Path, typer.Argument(metavar="SCENARIO", callback=expect_scenario, help="Scenario file (TOML).")
    ],
    port: Annotated[int, typer.Option("--port", metavar="N", min=0, max=65535, help="0: any that is free.")] = 0,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", metavar="", help="Open the page.")] = True,
    seed: SeedOption = 0,
    as_json: JsonOption = False,
) -> None:
    """Plan on a map in the browser: draw, drag, see it proved, fly it. The page is for this user on this machine alone.

    Ctrl-C ends it. With `--json` one line says where it is open.

    Example: `ipoa-mission studio missions/campus.toml`
    """
    from ipoa_mission.studio.extra import expect_extra

    expect_extra()
    from ipoa_mission.studio.bundle import built_page
    from ipoa_mission.studio.server import serve

    def tell_address(address: str) -> None:
        if as_json:
            tell_json({"scenario": str(scenario), "address": address}, indent=None)
        else:
            tell(f"{scenario.name} is open at {address}", "Ctrl-C ends it; whoever has this address can plan and fly")
        if browser:
            webbrowser.open(address)

    serve(scenario, built_page((lambda words: None) if as_json else tell), port, seed, tell_address)
