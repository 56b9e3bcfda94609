"""JSON Schema of patches for editors, generated from the models that read them.

It is draft 7 with definitions, for taplo ("Even Better TOML"): the editor completes keys, explains them and marks
invalid values. A file names its schema in a line: `#:schema ../patch.schema.json`.
"""

import ast
import inspect
import sys
from functools import cache
from itertools import pairwise
from typing import Any, Final

from pydantic import BaseModel, TypeAdapter
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import core_schema

from live.agents.formations.formation_spec import FormationSpec
from live.show.patch.patch import Patch
from live.show.patch.toml_model import BridgeTables

DRAFT: Final = "http://json-schema.org/draft-07/schema#"


class _DescribedSchema(GenerateJsonSchema):
    """Schemas of models whose keys are described by the docstrings of their fields."""

    def model_schema(self, schema: core_schema.ModelSchema) -> JsonSchemaValue:
        """Return the schema of one model."""
        found = super().model_schema(schema)
        for key, text in field_docs(schema["cls"]).items():
            found["properties"][key].setdefault("description", text)
        return found


def patch_schema(tables: BridgeTables = ()) -> dict[str, Any]:
    """Return the schema of a whole patch or of a file of its folder (so no key is required), with bridges' tables."""
    found = _to_draft7(Patch.model_json_schema(schema_generator=_DescribedSchema))
    for own in (_to_draft7(table.model_json_schema(schema_generator=_DescribedSchema)) for table in tables):
        found["properties"] |= own["properties"]
        found["definitions"] |= own.get("definitions", {})
    found["properties"]["formation"]["items"] = _formation()
    found["additionalProperties"] = False  # so that the editor marks a misspelt table
    found.pop("required", None)  # only show.toml has them
    return {"$schema": DRAFT, **found, "title": "A patch of ChoreoGraphics Live"}


def _formation() -> dict[str, Any]:
    """Schema of a `[[formation]]`, which has a reader of its own."""
    spec: dict[str, Any] = _to_draft7(TypeAdapter(FormationSpec).json_schema())
    properties = {}
    for name, told in field_docs(FormationSpec).items():
        field = spec["properties"][name]
        known = {key: field[key] for key in ("default", "enum") if key in field}
        properties[name] = {"description": " ".join(told.split()), **known}
    return {"type": "object", "properties": properties, "additionalProperties": False, "required": ["name"]}


def field_docs(cls: type) -> dict[str, str]:
    """Return the attribute docstring of each field of a class and its bases, as their sources have it.

    Reading sources takes long, so it is done for a schema or a reference, not when models are made (an option of
    pydantic's).
    """
    found = {}
    for base in reversed(cls.__mro__):
        if base in (object, BaseModel) or base.__qualname__ not in _classes(base.__module__):
            continue  # made by the program, as `parameter_section` does, which describes its fields itself
        for field, after in pairwise(_classes(base.__module__)[base.__qualname__].body):
            if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name) and isinstance(after, ast.Expr):
                found[field.target.id] = inspect.cleandoc(str(ast.literal_eval(after.value)))
    return found


@cache
def _classes(module: str) -> dict[str, ast.ClassDef]:
    tree = ast.parse(inspect.getsource(sys.modules[module]))
    return {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}


def _to_draft7(schema: Any) -> Any:
    """Convert to draft 7, and remove null, which TOML does not have."""
    if isinstance(schema, list):
        return [_to_draft7(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    found = {}
    for key, value in schema.items():
        if key == "default" and value is None:
            continue
        if key == "$ref":
            value = value.replace("#/$defs/", "#/definitions/")
        name = {"$defs": "definitions", "prefixItems": "items"}.get(key, key)
        found[name] = _to_draft7(value)
    some = found.get("anyOf")
    if some is not None:
        some = [item for item in some if item != {"type": "null"}]
        found["anyOf"] = some
        if len(some) == 1:
            del found["anyOf"]
            found = {**some[0], **found} if "$ref" not in some[0] else {**found, "allOf": some}
    elif "$ref" in found and len(found) > 1:  # draft 7 ignores keys next to a $ref
        found["allOf"] = [{"$ref": found.pop("$ref")}]
    if isinstance(found.get("title"), str) and "properties" not in found:
        del found["title"]  # "Beats Per Measure" says no more than the key itself
    return found
