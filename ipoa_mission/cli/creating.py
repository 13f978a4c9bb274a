import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ipoa_mission.cli.options import ForceOption, JsonOption
from ipoa_mission.cli.output import notes, print_json, print_lines
from ipoa_mission.cli.overwriting import expect_free
from ipoa_mission.errors import BadInput, WrongSuffix
from ipoa_mission.files import write_atomically

GivenOption = Annotated[
    list[str] | None, typer.Option("--answer", metavar="KEY=VALUE", help="Answer a question beforehand. Repeatable.")
]

if TYPE_CHECKING:
    from ipoa_mission.scenario.new import Question

BACK = "back"
UNKNOWN_ALTITUDE = "home's altitude is set to 0 m: give --answer altitude=METRES, or --elevation FILE"


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
        bool, typer.Option("--yes", "-y", metavar="", help="Ask nothing: use the map and the defaults.")
    ] = False,
    force: ForceOption = False,
    as_json: JsonOption = False,
) -> None:
    """Write a commented scenario file, from a few questions or from a map.

    Example: `ipoa-mission new town.toml --buildings town.geojson --yes`
    """
    from ipoa_mission.scenario.new import QUESTIONS, new_scenario, suggest_altitude, suggest_answers, taken_heights

    if target.suffix.lower() != ".toml":
        raise WrongSuffix(f'expected a name that ends in .toml, not in "{target.suffix}"', place=target)
    if not target.parent.is_dir():
        raise BadInput(f"expected a folder to write it to, but there is no {target.parent}", place=target)
    expect_free([target], force, ask=not (as_json or yes))
    given = {}
    for text in answer or ():
        key, equals, value = text.partition("=")
        if not equals:
            raise BadInput("expected KEY=VALUE", place=f"--answer {text}")
        given[key] = value
    answers = suggest_answers(buildings) | given
    if not yes:
        answers = _ask_all(given, answers, buildings, elevation)
    needed = [question.key for question in QUESTIONS if question.default is None and question.key not in answers]
    if needed:
        raise BadInput(
            "expected, but not there",
            hint=f"--answer {needed[0]}=..., or --buildings FILE, or leave out --yes and be asked",
            place=needed[0],
        )
    if elevation is not None and "altitude" not in answers:
        answers["altitude"] = suggest_altitude(elevation, answers["home"])
    remarks = [] if "altitude" in answers else [UNKNOWN_ALTITUDE]
    remarks += taken_heights(answers, buildings)
    write_atomically(target, new_scenario(answers, target, buildings, elevation))
    if as_json:
        print_json({"written": str(target), "answers": answers, "remarks": remarks})
    else:
        print_lines(f"written: {target}", *notes(remarks), f"plan it: ipoa-mission plan {shlex.quote(str(target))}")


def _ask_all(
    given: Mapping[str, str], suggested: Mapping[str, str], buildings: Path | None, elevation: Path | None
) -> dict[str, str]:
    """Ask for the missing answers; `back` returns to the question before."""
    from ipoa_mission.scenario.new import QUESTIONS, questions_about, suggest_altitude

    answers = dict(given)
    asked = [question for question in (*QUESTIONS, *questions_about(buildings)) if question.key not in given]
    typer.echo(f"Enter takes the answer in brackets; {BACK} returns to the question before.", err=True)
    number = 0
    while number < len(asked):
        question = asked[number]
        default = answers.get(question.key, suggested.get(question.key, question.default))
        if question.key == "altitude" and elevation is not None:
            default = suggest_altitude(elevation, answers["home"])
        answer = _ask(question, answers if question.key == "goal" else given, default)
        if answer != BACK:
            answers[question.key] = answer
        number = max(number - 1, 0) if answer == BACK else number + 1
    return answers


def _ask(question: "Question", others: Mapping[str, str], suggested: str | None) -> str:
    """Ask until the answer is valid or `back`; Enter takes the suggestion."""
    from ipoa_mission.scenario.new import check_goal

    words, shown = f"{question.words} ({question.form})", suggested is not None
    while True:
        given = str(typer.prompt(words, default=suggested or "", show_default=shown, err=True)).strip()
        try:
            if given != BACK:
                question.check(question.key, given)
                check_goal({**others, question.key: given})
        except BadInput as error:
            typer.echo(f"{error} ({BACK}: the question before)", err=True)
        else:
            return given
