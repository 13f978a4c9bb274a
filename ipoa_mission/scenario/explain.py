import difflib
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

from pydantic import BaseModel, ValidationError

from ipoa_mission.errors import BadInput, MissionError


def explained(error: ValidationError, table: Mapping[str, Any], model: type[BaseModel], source: str = "") -> BadInput:
    """Return pydantic's errors as one, a line each after `source`; at most 20, for speed."""
    most = 20
    problems = [problem for problem in error.errors(include_url=False) if not _is_consequence(problem)]
    wrong_at = dict[str, str]()
    for problem in problems[:most]:
        place, words = _explain(problem, table, model)
        other = words.removeprefix("expected ").partition(", not ")[0]  # of another branch of a union
        wrong_at[place] = f"{wrong_at[place]}, or {other}" if place in wrong_at else words
    (place, words), *others = [(f"{source}{place}".rstrip(".: "), words) for place, words in wrong_at.items()]
    lines = [f"{there}: {wrong}" if there else wrong for there, wrong in others]
    if len(problems) > most:
        lines.append(f"{source}and {len(problems) - most} more like these")
    of_keys = {"missing", "extra_forbidden", "union_tag_invalid", "union_tag_not_found"}
    asks_keys = any(problem["type"] in of_keys for problem in problems)
    hint = "`ipoa-mission schema` prints every key that a scenario may have" if asks_keys else None
    first = problems[0]
    cause = getattr(first.get("ctx", {}).get("error"), "__cause__", None)
    codes = {"missing": "missing", "union_tag_not_found": "missing", "extra_forbidden": "unknown-key"}
    code = cause.code if isinstance(cause, MissionError) else codes.get(first["type"])
    return BadInput(words, hint, code=code, place=place or None).followed_by(*lines)


_EXPECTED = {
    "greater_than": "a number greater than {gt:g}",
    "greater_than_equal": "a number of at least {ge:g}",
    "less_than_equal": "a number of at most {le:g}",
    "finite_number": "a finite number",
    "too_short": "at least {min_length} entries",
    "too_long": "{max_length} entries",
    **dict.fromkeys(("model_type", "model_attributes_type", "dict_type"), "a table"),
    **dict.fromkeys(("list_type", "tuple_type"), "a list"),
}


def _explain(problem: Any, table: Mapping[str, Any], model: type[BaseModel]) -> tuple[str, str]:
    """Return place and words, like `obstacles[0].radius` and `expected a number greater than 0, not -3`."""
    place = _place(problem["loc"], table)
    kind = problem["type"]
    value = problem["input"]
    limits = problem.get("ctx", {})
    match kind:
        case "missing":
            return place, "expected, but not there"
        case "extra_forbidden":
            key = str(problem["loc"][-1])
            keys = _known_keys(problem["loc"], model)
            near = [known for known in keys if key in known.split("_")] or difflib.get_close_matches(key, keys, n=1)
            others = [] if near else _tables_with(key, model)
            if others:
                return place, f"unknown key; {key} belongs {_or(others)}"
            return place, "unknown key" + (f"; did you mean {_or(near)}?" if near else "")
        case _ if kind in _EXPECTED:
            wanted = _EXPECTED[kind].format(**limits)
            value = len(value) if kind.startswith("too_") else value
        case "enum" | "literal_error" | "union_tag_invalid":
            if kind == "union_tag_invalid":
                place += ".kind"
                value = limits["tag"]
            wanted = limits.get("expected") or limits["expected_tags"]
        case "union_tag_not_found":
            return f"{place}.kind", "expected, but not there"
        case "timezone_aware" | "datetime_type" | "datetime_parsing" | "datetime_from_date_parsing":
            wanted = "a time with its offset, such as 2026-11-22T10:00:00Z"
            value = str(value)
        case "value_error":
            return place, str(limits["error"])
        case "string_pattern_mismatch":
            wanted = "a valid file name" if place == "name" else "letters, digits and underscores"
        case _ if kind.startswith(("float", "int")):
            wanted = "a whole number" if kind.startswith("int") else "a number"
        case _:
            return place, f"{lowered(problem['msg'])}, not {_shown(value)}"
    return place, f"expected {wanted}, not {_shown(value)}"


def _is_consequence(problem: Any) -> bool:
    """Return whether a list is too short only by its invalid entries."""
    return bool(problem["type"] == "too_short" and len(problem["input"]) >= problem["ctx"]["min_length"])


def _place(location: Sequence[int | str], table: Any) -> str:
    place = ""
    here = table
    for step in location:
        if isinstance(step, int):
            place += f"[{step}]"
            here = here[step] if isinstance(here, list | tuple) and step < len(here) else None
        elif isinstance(here, Mapping) and (step in here or step != here.get("kind")):
            place += f".{step}" if place else step
            here = here.get(step)
        # else it names a branch of a union
    return place


@cache
def _schema(model: type[BaseModel]) -> dict[str, Any]:
    return model.model_json_schema()


def _known_keys(location: Sequence[int | str], model: type[BaseModel]) -> list[str]:
    schema = _schema(model)
    here: Any = schema
    for step in location[:-1]:
        here = here.get("items", here) if isinstance(step, int) else here.get("properties", {}).get(step, here)
        here = _resolved(here, schema, str(step))
    return list(here.get("properties", {}))


def _tables_with(key: str, model: type[BaseModel]) -> list[str]:
    schema = _schema(model)
    tables = {name: _resolved(node, schema, "") for name, node in schema["properties"].items()}
    before = ["before all tables"] if key in tables and "properties" not in tables[key] else []
    return before + [f"in [{name}]" for name, table in tables.items() if key in table.get("properties", {})]


def _resolved(node: Any, schema: Any, tag: str) -> Any:
    node = next((choice for choice in node.get("anyOf", ()) if "$ref" in choice), node)
    if "discriminator" in node:
        mapping = node["discriminator"]["mapping"]
        node = {"$ref": mapping[tag]} if tag in mapping else node
    while "$ref" in node:
        node = schema["$defs"][node["$ref"].rsplit("/", 1)[-1]]
    return node


def _or(words: Sequence[str]) -> str:
    *others, last = words
    return f"{', '.join(others)} or {last}" if others else last


def lowered(message: str) -> str:
    return message[:1].lower() + message[1:]


def _shown(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    text = repr(value) if not isinstance(value, dict | list) else f"a {type(value).__name__}"
    return text if len(text) <= 60 else text[:57] + "..."
