import re
import tomllib
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from ipoa_mission.errors import BadInput, TooLarge, WrongFormat
from ipoa_mission.files import read_text
from ipoa_mission.scenario.explain import explained, lowered
from ipoa_mission.scenario.model import Scenario, added_sections

LONGEST_KEY = 16  # parts; tomllib is quadratic in their number
_PART = r"""(?:[\w-]++|"(?:\\.|[^"\\\n])*+"|'[^'\n]*+')"""
# Multi-line strings, comments, keys of too many parts, the rest.
_WORDS = re.compile(
    rf'''"""(?:\\.|[^\\"]|"(?!""))*+(?:"""|\Z)|\'{{3}}(?:[^\']|\'(?!\'\'))*+(?:\'{{3}}|\Z)|\#[^\n]*+|'''
    rf"(?P<long>{_PART}(?:[ \t]*+\.[ \t]*+{_PART}){{{LONGEST_KEY}}})|{_PART}",
    re.DOTALL,
)


def read_scenario(path: str | Path) -> Scenario:
    """Read a scenario from a TOML file, with all its maps.

    Args:
        path: its name is the default name.

    Returns:
        The scenario.

    Raises:
        BadInput: with file, place and expected value; or a library is missing.

    Example:
        >>> from ipoa_mission import read_scenario
        >>> read_scenario("missions/sitl.toml").name
        'sitl'
    """
    return scenario_of(read_table(Path(path)), Path(path))


def read_table(path: Path) -> dict[str, Any]:
    return parse_toml(read_text(path), path)


def parse_scenario(text: str, path: Path) -> Scenario:
    return scenario_of(parse_toml(text, path), path)


def scenario_of(table: dict[str, Any], path: Path) -> Scenario:
    """Return the scenario; files are relative to `path`."""
    try:
        scenario = Scenario.model_validate({"name": path.stem} | table, context={"folder": str(path.parent)})
    except ValidationError as error:
        raise explained(error, table, Scenario, f"{path}: ") from error
    try:
        scenario.read_maps()
    except BadInput as error:
        if re.split(r"[.:\[ ]", str(error), maxsplit=1)[0] not in Scenario.model_fields | added_sections():
            raise
        raise error.at(path) from error
    return scenario.with_wind_read()


def parse_toml(text: str, path: Path) -> dict[str, Any]:
    for word in _WORDS.finditer(text):
        if word["long"]:
            line = text.count("\n", 0, word.start()) + 1
            raise BadInput(f"expected a key of at most {LONGEST_KEY} parts", place=f"{path}: line {line}")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        at = re.search(r"at line (\d+)", str(error))
        decimal_comma = r"=\s*([-+]?\d+),(\d+)\s*(?:#.*)?$"
        if at is not None and (comma := re.search(decimal_comma, text.split("\n")[int(at[1]) - 1].rstrip())):
            words = f"expected a number with a point, {comma[1]}.{comma[2]}, not {comma[1]},{comma[2]}"
            raise WrongFormat(words, place=f"{path}: line {at[1]}") from error
        raise WrongFormat(f"{lowered(str(error))}", hint="a scenario is a TOML file", place=path) from error
    except RecursionError:
        raise TooLarge("expected a scenario, not endlessly nested brackets", place=path) from None
    except ValueError:
        raise TooLarge("expected numbers that fit in 64 bits, not one of thousands of digits", place=path) from None
