"""Update the tables of keys in docs/scenario.md and docs/scenario/ from the models that read a scenario.

    python -m tools.generate.scenario_reference

A table is between `<!-- keys of NAME -->` and `<!-- end -->`, NAME is a table of the schema. All else in the pages is
written by hand and stays.
"""

import json
import re
from functools import cache
from typing import Any

from ipoa_mission.files import read_text, write_atomically
from ipoa_mission.scenario import Scenario
from tools import REPOSITORY, command_line

INDEX = REPOSITORY / "docs" / "scenario.md"
PAGES = [INDEX, *sorted((REPOSITORY / "docs" / "scenario").glob("*.md"))]
TABLE = re.compile(r"(<!-- keys of (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)
HEADING = re.compile(r"^##? (.*\[\w+\].*)$", re.MULTILINE)


def refreshed(text: str) -> str:
    return TABLE.sub(lambda match: f"{match[1]}{table_of_keys(match[2], schema_tables())}{match[3]}", text)


@cache
def schema_tables() -> dict[str, Any]:
    schema = Scenario.model_json_schema()
    return {"Scenario": schema, **schema["$defs"]}


def table_of_keys(name: str, tables: dict[str, Any]) -> str:
    section, links = tables[name], sections() if name == "Scenario" else {}
    position = tables["Horizontal"]["properties"].keys()  # of obstacles: as of a place
    inherited = position if name.endswith("Section") and position <= section["properties"].keys() else ()
    rows = ["| key | value | left out | meaning |", "|---|---|---|---|"]
    for key, schema in section["properties"].items():
        if "const" in schema or key in inherited:  # a `kind`, which the heading has
            continue
        meaning = schema.get("description") or tables[schema["$ref"].rsplit("/", 1)[-1]]["description"]
        left_out = "needed" if key in section.get("required", ()) else shown(schema.get("default"))
        linked = f"[`{key}`]({links[key]})" if key in links else f"`{key}`"
        cells = (linked, value(schema, tables), left_out, " ".join(meaning.split()))
        rows.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(rows) + "\n"


def sections() -> dict[str, str]:
    return {
        key: f"scenario/{page.name}#{re.sub(r'[^a-z -]', '', heading.lower()).replace(' ', '-')}"
        for page in PAGES[1:]
        for heading in HEADING.findall(read_text(page))
        for key in re.findall(r"\[(\w+)\]", heading)
    }


def value(schema: dict[str, Any], tables: dict[str, Any]) -> str:
    match schema:
        case {"$ref": str(ref)}:
            target = tables[ref.rsplit("/", 1)[-1]]
            return value(target, tables) if "enum" in target else "a table"
        case {"const": str(word)}:
            return f'`"{word}"`'
        case {"enum": list(words)}:
            return " or ".join(f'`"{word}"`' for word in words)
        case {"anyOf": list(options)}:
            return " or ".join(value(option, tables) for option in options if option.get("type") != "null")
        case {"oneOf": _}:
            return "a table with a `kind`"
        case {"type": "array", "prefixItems": list(items)}:
            return "[" + ", ".join(value(item, tables) for item in items) + "]"
        case {"type": "array", "items": dict(items)}:
            return f"a list: {value(items, tables)}, ..."
        case {"type": "string", "format": "path"}:
            return "a file"
        case {"type": "string"}:
            return "a word" if "pattern" in schema else "a text"
        case {"type": "boolean"}:
            return "true or false"
        case {"type": "object"}:
            return "a table"
    limits = {"exclusiveMinimum": "> ", "minimum": "≥ ", "exclusiveMaximum": "< ", "maximum": "≤ "}
    words = [sign + f"{schema[limit]:.4g}" for limit, sign in limits.items() if limit in schema]
    return " ".join(["a whole number" if schema["type"] == "integer" else "a number", ", ".join(words)]).strip()


def shown(default: Any) -> str:
    if default is None or default in ([], {}) or isinstance(default, dict):
        return "—"
    return f"`{json.dumps(default)}`"


if __name__ == "__main__":
    command_line(__doc__).parse_args()
    for page in PAGES:
        write_atomically(page, refreshed(read_text(page)))
