"""`new`: a first scenario from a few answers, or from a map."""

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ipoa_mission.cli.options import ForceOption, JsonOption
from ipoa_mission.cli.overwriting import expect_free
from ipoa_mission.cli.telling import notes, tell, tell_json
from ipoa_mission.errors import BadInput
from ipoa_mission.files import write_atomically

GivenOption = Annotated[
    list[str] | None, typer.Option("--answer", metavar="KEY=VALUE", help="Answer a question beforehand. Repeatable.")
]

if TYPE_CHECKING:
    from ipoa_mission.scenario.new import Question

UNKNOWN_ALTITUDE = "home's altitude is taken as 0 m: --answer altitude=METRES, or --elevation FILE"


def new(
    target: Annotated[Path, typer.Argument(metavar="SCENARIO", help="Scenario file to write (.toml).")],
    buildings: Annotated[
        Path | None,
        typer.Option("--buildings", metavar="FILE", help="GeoJSON, .osm.pbf, GeoParquet or another map."),
    ] = None,
    elevation: Annotated[
        Path | None, typer.Option("--elevation", metavar="FILE", help="Elevation model: GeoTIFF or SRTM .hgt.")
    ] = None,
    answer: GivenOption = None,
    yes: Annotated[
        bool, typer.Option("--yes", "-y", metavar="", help="Ask nothing: take what the map and the defaults say.")
    ] = False,
    force: ForceOption = False,
    as_json: JsonOption = False,
) -> None:
    """Write a commented scenario file, from a few questions or from a map.

    Example: `ipoa-mission new town.toml --buildings town.geojson --yes`
    """
    from ipoa_mission.scenario.new import QUESTIONS, new_scenario, questions_about, suggest_answers, taken_heights

    if target.suffix.lower() != ".toml":
        raise BadInput(f'{target}: expected a name that ends in .toml, not in "{target.suffix}"')
    if not target.parent.is_dir():
        raise BadInput(f"{target}: expected a folder to write it to, but there is no {target.parent}")
    expect_free([target], force, ask=not (as_json or yes))
    answers = suggest_answers(buildings, elevation)
    for text in answer or ():
        key, equals, value = text.partition("=")
        if not equals:
            raise BadInput(f"--answer {text}: expected KEY=VALUE")
        answers[key] = value
    if not yes:
        given = {key for key, _, _ in (text.partition("=") for text in answer or ())}
        for question in (*QUESTIONS, *questions_about(buildings)):
            if question.key not in given:
                answers[question.key] = _ask(question, answers)
    needed = [question.key for question in QUESTIONS if question.default is None and question.key not in answers]
    if needed:
        raise BadInput(
            f"{needed[0]}: expected, but not there",
            hint=f"--answer {needed[0]}=..., or --buildings FILE, or leave out --yes and be asked",
        )
    remarks = [] if "altitude" in answers or elevation is not None else [UNKNOWN_ALTITUDE]
    remarks += taken_heights(answers, buildings)
    write_atomically(target, new_scenario(answers, target, buildings, elevation))
    if as_json:
        tell_json({"written": str(target), "answers": answers, "remarks": remarks})
    else:
        tell(f"written: {target}", *notes(remarks), f"plan it: ipoa-mission plan {shlex.quote(str(target))}")


def _ask(question: "Question", answers: dict[str, str]) -> str:
    """An answer that will do, after as many tries as it takes; what a map suggests is taken by Enter."""
    from ipoa_mission.scenario.new import check_goal

    while True:
        suggested = answers.get(question.key, question.default)
        given = str(typer.prompt(f"{question.words} ({question.form})", default=suggested, err=True))
        try:
            question.check(question.key, given)
            check_goal({**answers, question.key: given})
        except BadInput as error:
            typer.echo(error, err=True)
        else:
            return given
