"""`studio`: the page on which a flight is drawn, planned, proved, flown and watched."""

import webbrowser
from pathlib import Path
from typing import Annotated

import typer

from ipoa_mission.cli.options import SeedOption, expect_scenario
from ipoa_mission.cli.telling import tell


def studio(
    scenario: Annotated[
        Path, typer.Argument(metavar="SCENARIO", callback=expect_scenario, help="Scenario file (TOML).")
    ],
    port: Annotated[int, typer.Option("--port", metavar="N", min=0, max=65535, help="0: any that is free.")] = 0,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", metavar="", help="Open the page.")] = True,
    seed: SeedOption = 0,
) -> None:
    """Plan on a map in the browser: draw, drag, see it proved, fly it. The page is for this user on this machine alone.

    Ctrl-C ends it. Example: `ipoa-mission studio missions/campus.toml`
    """
    from ipoa_mission.studio.extra import expect_extra

    expect_extra()
    from ipoa_mission.studio.bundle import built_page
    from ipoa_mission.studio.server import serve

    def tell_address(address: str) -> None:
        tell(f"{scenario.name} is open at {address}", "Ctrl-C ends it; whoever has this address can plan and fly")
        if browser:
            webbrowser.open(address)

    serve(scenario, built_page(tell), port, seed, tell_address)
