"""`studio`: the page on which a flight is drawn, planned, proved, flown and watched."""

import webbrowser
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

import typer

from ipoa_mission.cli.options import JsonOption, ScenarioOption, SeedOption, or_packed
from ipoa_mission.cli.output import tell, tell_json
from ipoa_mission.errors import BadInput, MissionError

LIBRARIES = ("starlette", "uvicorn", "websockets", "tomlkit")  # beyond what the package itself needs


def studio(
    file: Annotated[
        Path | None,
        typer.Argument(
            metavar="[FILE]",
            callback=lambda path: None if path is None else or_packed(path),
            help="Scenario (.toml), mission (.plan, .waypoints) or log (.tlog, .bin, .ulg); left out: a page to begin.",
        ),
    ] = None,
    home: Annotated[
        tuple[float, float, float] | None,
        typer.Option("--new", metavar="LAT LON ALT", help="Begin a new scenario, home there: degrees, metres AMSL."),
    ] = None,
    port: Annotated[int, typer.Option("--port", metavar="N", min=0, max=65535, help="0: any that is free.")] = 0,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", metavar="", help="Open the page.")] = True,
    tiles: Annotated[
        str | None,
        typer.Option(
            "--tiles",
            metavar="URL|FILE",
            help="A map under it, remembered: an address with {z}, {x}, {y}, or an MBTiles or PMTiles file; `none` "
            "forgets it.",
        ),
    ] = None,
    attribution: Annotated[
        str | None, typer.Option("--attribution", metavar="WORDS", help="Whose map that is, shown on it.")
    ] = None,
    world: ScenarioOption = None,
    seed: SeedOption = 0,
    as_json: JsonOption = False,
) -> None:
    """Plan on a map in the browser: draw, drag, see it proved, fly it. The page is for this user on this machine alone.

    Ctrl-C ends it. With `--json` one line says where it is open.

    Example: `ipoa-mission studio missions/campus.toml`
    """
    missing = [name for name in LIBRARIES if find_spec(name) is None]
    if missing:
        words = f"the studio needs {', '.join(missing)}"
        raise MissionError(words, hint="pip install 'ipoa-mission[studio]'", code="package-missing")
    from ipoa_mission.studio.bundle import built_page
    from ipoa_mission.studio.tiles import chosen_tiles
    from ipoa_mission.studio.web_server import serve

    page = built_page((lambda words: None) if as_json else tell)
    file = Path("mission.toml") if file is None and home is not None else file
    if file is not None and (home is not None or not file.exists()):
        _begin(file, home)

    source = chosen_tiles(tiles, attribution)

    def tell_address(address: str) -> None:
        if as_json:
            tell_json({"file": None if file is None else str(file), "address": address}, indent=None)
        else:
            name = "the start page" if file is None else file.name
            tell(f"{name} is open at {address}", "Ctrl-C ends it; whoever has this address can plan and fly")
            if source is not None:
                tell(f"map tiles: {source.origin or source.shown.attribution} (remembered; --tiles none forgets them)")
        if browser:
            webbrowser.open(address)

    with suppress(KeyboardInterrupt):  # that is how it is meant to end
        serve(file, page, port, seed, tell_address, source, world)


def _begin(target: Path, home: tuple[float, float, float] | None) -> None:
    """Write a new scenario with a goal north of home, to be dragged.

    Raises:
        BadInput: nobody says where it is to begin, or there is such a file already.
    """
    from ipoa_mission.studio.lobby import begin_scenario

    if home is None:
        raise BadInput(
            "expected a scenario, but there is no such file",
            hint="a new one begins at home: --new LAT LON ALT; or from a map: ipoa-mission new",
            place=target,
        )
    if target.exists():
        words = f"{target} is there already"
        raise BadInput(words, hint="leave --new out, or name another file", code="already-there", place="--new")
    begin_scenario(target, home)
