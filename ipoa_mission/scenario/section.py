import ast
import inspect
from collections.abc import Iterator, Mapping
from itertools import pairwise
from pathlib import Path
from textwrap import dedent
from typing import Annotated, Any, Self

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, GetJsonSchemaHandler, ValidationInfo, model_validator


class Section(BaseModel):
    """A table of the scenario file."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, defer_build=True)

    @classmethod
    def __get_pydantic_json_schema__(cls, core_schema: Any, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """Describe fields by the strings after them; pydantic's own way slows imports."""
        schema = handler(core_schema)
        properties = handler.resolve_ref_schema(schema).get("properties", {})
        for kind in cls.__mro__:
            if issubclass(kind, BaseModel) and kind is not BaseModel:
                for name, words in _attribute_docstrings(kind):
                    properties.get(name, {}).setdefault("description", words)
        return schema

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """Return a copy, unchecked, without cached values."""
        copied = super().model_copy(update=update, deep=deep)
        for name in copied.__dict__.keys() - type(self).model_fields.keys():
            del copied.__dict__[name]
        return copied


def _attribute_docstrings(kind: type) -> Iterator[tuple[str, str]]:
    (definition,) = ast.parse(dedent(inspect.getsource(kind))).body
    assert isinstance(definition, ast.ClassDef)
    for field, words in pairwise(definition.body):
        match field, words:
            case ast.AnnAssign(target=ast.Name(name)), ast.Expr(value=ast.Constant(value=str(text))):
                yield name, inspect.cleandoc(text)


def merged(settings: Mapping[str, Any], table: Mapping[str, Any]) -> dict[str, Any]:
    both = {**settings, **table}
    for key in settings.keys() & table.keys():
        if isinstance(settings[key], Mapping) and isinstance(table[key], Mapping):
            both[key] = merged(settings[key], table[key])
    return both


def one_of(*choices: str) -> Any:
    """Return a validator: one choice, like `capacity_mah and voltage`, has all its keys, and no other has any."""

    def check(section: BaseModel) -> BaseModel:
        given = [[getattr(section, key) is not None for key in choice.split(" and ")] for choice in choices]
        if sum(map(any, given)) != 1 or sum(map(all, given)) != 1:
            raise ValueError(f"expected either {', or '.join(choices)}")
        return section

    return model_validator(mode="after")(check)


def existing_file(what: str) -> AfterValidator:
    """Resolve a path relative to the scenario file."""

    def resolve(value: Any, info: ValidationInfo) -> Any:
        if not isinstance(value, Path):
            return value
        path = Path((info.context or {}).get("folder", ".")) / value
        if not path.is_file():
            raise ValueError(f"expected {what}, but there is no file {path}")
        return path

    return AfterValidator(resolve)


# Strict: refuse true and false, which Python takes for 1 and 0.
Number = Annotated[float, Field(strict=True)]
Positive = Annotated[float, Field(gt=0, strict=True)]
Count = Annotated[int, Field(gt=0, strict=True)]
NotNegative = Annotated[float, Field(ge=0, strict=True)]
Latitude = Annotated[float, Field(ge=-90, le=90, strict=True)]
Longitude = Annotated[float, Field(ge=-180, le=180, strict=True)]
