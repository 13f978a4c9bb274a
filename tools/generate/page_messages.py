"""Print the JSON schema of all messages between studio and page, from which `npm run types` makes TypeScript types.

python -m tools.generate.page_messages
"""

import json
from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import models_json_schema

from ipoa_mission.scenario import Scenario
from ipoa_mission.studio.answers import Answer
from ipoa_mission.studio.requests import Request
from ipoa_mission.survey.survey_section import SurveySection
from tools import command_line


def schema() -> dict[str, Any]:
    unions = {"Answer": _members(Answer), "Request": _members(Request)}
    kinds = [(kind, "serialization") for members in unions.values() for kind in members]
    read = [(Scenario, "validation"), (SurveySection, "validation")]
    _, definitions = models_json_schema([*kinds, *read])  # type: ignore[list-item]
    for name, members in unions.items():
        definitions["$defs"][name] = {"oneOf": [{"$ref": f"#/$defs/{member.__name__}"} for member in members]}
    definitions["$defs"]["Document"]["properties"]["scenario"] = {"$ref": "#/$defs/Scenario"}
    definitions["$defs"]["Scenario"]["properties"]["survey"] = {"$ref": "#/$defs/SurveySection"}
    plain: dict[str, Any] = _plain(definitions)
    return {"title": "Messages", "type": "object", "additionalProperties": False} | plain


def _plain(node: Any) -> Any:
    """Remove titles of members, and write tuples as TypeScript's generator reads them."""
    if isinstance(node, list):
        return [_plain(one) for one in node]
    if not isinstance(node, dict):
        return node
    node = {key: _plain(value) for key, value in node.items() if key != "title" or not isinstance(value, str)}
    if "prefixItems" in node:
        node["items"] = node.pop("prefixItems")
    constant = [name for name, one in node.get("properties", {}).items() if isinstance(one, dict) and "const" in one]
    if constant:  # it identifies a message
        node["required"] = sorted({*node.get("required", []), *constant})
    return node


def _members(union: Any) -> tuple[type[BaseModel], ...]:
    return tuple(union.__origin__.__args__)


if __name__ == "__main__":
    command_line(__doc__).parse_args()
    print(json.dumps(schema(), indent=1))
