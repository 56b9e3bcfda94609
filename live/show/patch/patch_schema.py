"""JSON Schema of patches for editors, generated from the models that read them.

It is draft 7 with definitions, for taplo ("Even Better TOML"): the editor completes keys, explains them and marks
invalid values. A file names its schema in a line: `#:schema ../patch.schema.json`.
"""

import ast
import inspect
import textwrap
from itertools import pairwise
from typing import Any, Final

from pydantic import TypeAdapter

from live.agents.formations.formation_spec import FormationSpec
from live.show.patch.patch import Patch
from live.show.patch.toml_model import BridgeTables

DRAFT: Final = "http://json-schema.org/draft-07/schema#"


def patch_schema(tables: BridgeTables = ()) -> dict[str, Any]:
    """Return the schema of a whole patch or of a file of its folder (so no key is required), with bridges' tables."""
    found = _to_draft7(Patch.model_json_schema())
    for own in (_to_draft7(section.model_json_schema()) for section in tables):
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
    for name, told in _field_docs(FormationSpec).items():
        field = spec["properties"][name]
        properties[name] = {"description": told, **{key: field[key] for key in ("default", "enum") if key in field}}
    return {"type": "object", "properties": properties, "additionalProperties": False, "required": ["name"]}


def _field_docs(cls: type) -> dict[str, str]:
    """The attribute docstring of each field of a dataclass."""
    body = ast.parse(textwrap.dedent(inspect.getsource(cls))).body[0]
    assert isinstance(body, ast.ClassDef)
    found = {}
    for field, after in pairwise(body.body):
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name) and isinstance(after, ast.Expr):
            found[field.target.id] = " ".join(str(ast.literal_eval(after.value)).split())
    return found


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
