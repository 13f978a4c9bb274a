"""`new`: a first scenario from a few answers, or from a map."""

import shlex
from pathlib import Path
from typing import Annotated

import typer

from ipoa_mission.cli.options import JsonOption
from ipoa_mission.cli.telling import notes, tell, tell_json

GivenOption = Annotated[
    list[str] | None, typer.Option("--answer", metavar="KEY=VALUE", help="Answer a question beforehand. Repeatable.")
]

UNKNOWN_ALTITUDE = "home's altitude is taken as 0 m: --answer altitude=METRES, or --elevation FILE"


def new(
    target: Annotated[Path, typer.Argument(metavar="SCENARIO", help="Scenario file to write (.toml).")],
    buildings: Annotated[
        Path | None,
        typer.Option("--buildings", metavar="FILE", help="GeoJSON as OpenStreetMap exports give it, or KML."),
    ] = None,
    elevation: Annotated[
        Path | None, typer.Option("--elevation", metavar="FILE", help="Elevation model: GeoTIFF or SRTM .hgt.")
    ] = None,
    answer: GivenOption = None,
    yes: Annotated[
        bool, typer.Option("--yes", "-y", metavar="", help="Ask nothing: take what the map and the defaults say.")
    ] = False,
    force: Annotated[bool, typer.Option("--force", metavar="", help="Write over a file that is there.")] = False,
    as_json: JsonOption = False,
) -> None:
    """Write a commented scenario file, from a few questions or from a map.

    Example: `ipoa-mission new town.toml --buildings town.geojson --yes`
    """
    from ipoa_mission.errors import BadInput
    from ipoa_mission.files import write_atomically
    from ipoa_mission.scenario.new import QUESTIONS, new_scenario, suggest_answers

    if target.suffix != ".toml":
        raise BadInput(f'{target}: expected a name that ends in .toml, not in "{target.suffix}"')
    if not target.parent.is_dir():
        raise BadInput(f"{target}: expected a folder to write it to, but there is no {target.parent}")
    if target.exists() and not force:
        raise BadInput(f"{target}: there is such a file already", hint="--force writes over it")
    answers = suggest_answers(buildings, elevation)
    for text in answer or ():
        key, equals, value = text.partition("=")
        if not equals:
            raise BadInput(f"--answer {text}: expected KEY=VALUE")
        answers[key] = value
    if not yes:
        for question in QUESTIONS:
            if question.key not in answers:
                answers[question.key] = typer.prompt(
                    f"{question.words} ({question.form})", default=question.default, err=True
                )
                question.check(question.key, answers[question.key])
    needed = [question.key for question in QUESTIONS if question.default is None and question.key not in answers]
    if needed:
        raise BadInput(
            f"{needed[0]}: expected, but not there",
            hint=f"--answer {needed[0]}=..., or --buildings FILE, or leave out --yes and be asked",
        )
    remarks = [] if "altitude" in answers or elevation is not None else [UNKNOWN_ALTITUDE]
    write_atomically(target, new_scenario(answers, target, buildings, elevation))
    if as_json:
        tell_json({"written": str(target), "answers": answers, "remarks": remarks})
    else:
        tell(f"written: {target}", *notes(remarks), f"plan it: ipoa-mission plan {shlex.quote(str(target))}")
