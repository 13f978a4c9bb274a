import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from ipoa_mission.cli.interrupting import ChangesMade, interruptible
from ipoa_mission.cli.planners import Planners, PlanOptions, planner_of, planners
from ipoa_mission.errors import BadInput, OptionConflict, WrongSuffix
from ipoa_mission.files import write_atomically
from ipoa_mission.options import ForceOption, HomeOption, JsonOption, argument, expect_scenario, flag
from ipoa_mission.terminal import expect_folder, expect_free, notes, print_json, print_lines

if TYPE_CHECKING:
    from ipoa_mission.scenario import Scenario


@interruptible
def plan(
    changes: ChangesMade,
    asked: PlanOptions,
    added: Planners,
    scenario: Annotated[
        Path | None,
        argument(
            "[SCENARIO]",
            f"Scenario file (TOML), or `campus`{''.join(f'; optional with {p.option}' for p in planners())}.",
            callback=lambda path: None if path is None else expect_scenario(path),
        ),
    ] = None,
    split: Annotated[
        bool, flag("--split", "Without enough battery, split into the fewest flights: NAME-1.plan ...")
    ] = False,
) -> None:
    """Plan a scenario and write its mission: NAME.plan (QGroundControl), NAME.waypoints, and NAME.json about it.

    NAME is the scenario's. Unchanged files of an earlier plan are overwritten.

    Example: `ipoa-mission plan missions/campus.toml --out out --seed 7`
    """
    from ipoa_mission.cli.flight_output import print_parts, print_planned
    from ipoa_mission.cli.mission_source import adapt_scenario
    from ipoa_mission.flight.flight import plan_flight, plan_for_batteries

    to = asked.files
    out = to.folder
    expect_folder(out)
    adapted = adapt_scenario(_read(scenario, added), asked.search, asked.flown_by).ignoring(asked.ignore or ())
    planner = planner_of(adapted, added)
    if planner is not None:
        planner.plan(adapted, asked, changes)
        return

    to.expect_plans([adapted.name])
    with changes.planning() as show:
        planned = plan_for_batteries if split else plan_flight
        flight = planned(adapted, wind=asked.flown_by.air, seed=asked.search.seed, progress=show)
    if flight.parts:
        expect_free([out / f"{name}.plan" for name in flight.names], to.force, ask=not to.as_json)
    files = flight.write(out, to.report)
    if to.as_json:
        print_json(flight.summary() | {"written": [str(file) for file in files]})
    elif flight.parts:
        print_parts(flight, files)
    else:
        print_planned(flight, files)


def _read(path: Path | None, added: Planners) -> "Scenario":
    from ipoa_mission.scenario import read_scenario

    for planner in added:
        scenario = planner.scenario(path)
        if scenario is not None:
            return scenario
    if path is None:
        raise OptionConflict(", or ".join(("expected a scenario", *(planner.instead for planner in added))))
    return read_scenario(path)


@dataclass
class PlaceOptions:
    home: HomeOption = None
    buildings: Annotated[Path | None, flag("--buildings", "GeoJSON, .osm.pbf or another map.", "FILE")] = None
    elevation: Annotated[Path | None, flag("--elevation", "Elevation model: GeoTIFF or SRTM .hgt.", "FILE")] = None


def new(
    target: Annotated[Path, argument("SCENARIO", "Scenario file to write (.toml).")],
    at: PlaceOptions,
    force: ForceOption = False,
    as_json: JsonOption = False,
) -> None:
    """Write a commented scenario file to edit, at a place or for a map.

    Example: `ipoa-mission new town.toml --buildings town.geojson`
    """
    from ipoa_mission.scenario import new_scenario

    if target.suffix.lower() != ".toml":
        raise WrongSuffix(f'expected a name that ends in .toml, not in "{target.suffix}"', place=target)
    if not target.parent.is_dir():
        raise BadInput(f"expected a folder to write it to, but there is no {target.parent}", place=target)
    expect_free([target], force, ask=not as_json)
    text, remarks = new_scenario(target, at.home, at.buildings, at.elevation)
    write_atomically(target, text)
    if as_json:
        print_json({"written": str(target), "remarks": list(remarks)})
    else:
        print_lines(f"written: {target}", *notes(remarks), f"plan it: ipoa-mission plan {shlex.quote(str(target))}")


def schema() -> None:
    """Print the JSON Schema of scenario files, for completion and checks in editors.

    Example: `ipoa-mission schema > scenario.schema.json`
    """
    from ipoa_mission.scenario import Scenario

    print_json(Scenario.model_json_schema())
