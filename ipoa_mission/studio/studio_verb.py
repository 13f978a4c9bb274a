import webbrowser
from contextlib import suppress
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

from ipoa_mission.errors import BadInput, MissionError
from ipoa_mission.options import JsonOption, ScenarioOption, SeedOption, argument, flag, or_packed
from ipoa_mission.terminal import print_json, print_lines

LIBRARIES = ("starlette", "uvicorn", "websockets", "tomlkit")


@dataclass
class PageOptions:
    port: Annotated[int, flag("--port", "0: any free port.", "N", min=0, max=65535)] = 0
    browser: Annotated[bool, flag("--browser/--no-browser", "Open the page.")] = True
    tiles: Annotated[str | None, flag("--tiles", "Map tiles: an address with {z}, {x}, {y}.", "URL")] = None
    attribution: Annotated[str | None, flag("--attribution", "Attribution of the map, shown on it.", "WORDS")] = None
    world: ScenarioOption = None
    seed: SeedOption = 0


def studio(
    page: PageOptions,
    file: Annotated[
        Path | None,
        argument(
            "[FILE]",
            "Scenario (.toml), mission (.plan, .waypoints) or log (.tlog, .bin, .ulg); default: the start page.",
            callback=lambda path: None if path is None else or_packed(path),
        ),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Plan on a map in the browser: draw, drag, prove, fly. The page is for this user on this machine only.

    Ctrl-C ends it. With `--json` one line gives its address.

    Example: `ipoa-mission studio missions/campus.toml`
    """
    if file is not None and not file.exists():
        hint = "`ipoa-mission new`, or the start page, begins a scenario"
        raise BadInput("expected a scenario, mission or log: no such file", hint=hint, place=file)
    missing = [name for name in LIBRARIES if find_spec(name) is None]
    if missing:
        words = f"the studio needs {', '.join(missing)}"
        raise MissionError(words, hint="pip install 'ipoa-mission[studio]'", code="package-missing")
    from ipoa_mission.studio.bundle import built_page
    from ipoa_mission.studio.web_server import ServerOptions, serve, tiles_at

    built = built_page((lambda words: None) if as_json else print_lines)
    tiles = None if page.tiles is None else tiles_at(page.tiles, page.attribution)

    def tell_address(address: str) -> None:
        if as_json:
            print_json({"file": None if file is None else str(file), "address": address}, indent=None)
        else:
            name = "the start page" if file is None else file.name
            print_lines(f"{name} is open at {address}", "Ctrl-C ends it; anyone with this address can plan and fly")
            if tiles is not None:
                print_lines(f"map tiles: {tiles.address}")
        if page.browser:
            webbrowser.open(address)

    with suppress(KeyboardInterrupt):  # the regular end
        serve(file, ServerOptions(built, page.port, page.seed, tiles), tell_address, page.world)
