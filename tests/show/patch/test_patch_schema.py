"""The editor's JSON Schema accepts and refuses as the patch reader does, by a small draft 7 validator written here."""

import json
import re
import tomllib

import pytest
from pydantic import ConfigDict
from typer.testing import CliRunner

from live.app.bridges import installed_bridges
from live.cli.main import app
from live.show.patch.patch import Patch
from live.show.patch.patch_reader import read_sources
from live.show.patch.patch_schema import field_docs, patch_schema
from live.show.patch.patch_search_path import PATCHES
from live.show.patch.section_base import Section

SCHEMA = patch_schema(installed_bridges().patch_tables())
KINDS = {"object": dict, "array": list, "string": str, "boolean": bool, "integer": int, "number": (int, float)}
LENGTHS = {str: ("minLength", "maxLength"), list: ("minItems", "maxItems"), dict: ("minProperties", "maxProperties")}
KNOWN = {
    *("type", "properties", "additionalProperties", "items", "anyOf", "allOf", "$ref", "enum", "const", "required"),
    *("minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum", "minItems", "maxItems", "minLength", "maxLength"),
    *("minProperties", "maxProperties", "pattern"),
    *("description", "default", "title", "definitions", "$schema"),
}


def schema_errors(value, schema=SCHEMA, where="patch"):
    """The errors of a value by draft 7, each with its place."""
    assert set(schema) <= KNOWN, schema
    if "$ref" in schema:
        return schema_errors(value, SCHEMA["definitions"][schema["$ref"].removeprefix("#/definitions/")], where)
    found = [fault for part in schema.get("allOf", ()) for fault in schema_errors(value, part, where)]
    if "anyOf" in schema and all(schema_errors(value, part, where) for part in schema["anyOf"]):
        found.append(f"{where}: none of what is possible")
    kind = schema.get("type")
    if kind and not (isinstance(value, KINDS[kind]) and not (isinstance(value, bool) and kind != "boolean")):
        return [*found, f"{where}: no {kind}"]
    if value not in schema.get("enum", [value]) or value != schema.get("const", value):
        found.append(f"{where}: not one of those")
    if isinstance(value, int | float) and not isinstance(value, bool):
        low, high = schema.get("minimum", value), schema.get("maximum", value)
        below, above = schema.get("exclusiveMinimum"), schema.get("exclusiveMaximum")
        inside = low <= value <= high and (below is None or value > below) and (above is None or value < above)
        found += [] if inside else [f"{where}: out of range"]
    if isinstance(value, str) and not re.search(schema.get("pattern", ""), value):
        found.append(f"{where}: of another form")
    if isinstance(value, str | list | dict):
        least, most = LENGTHS[type(value)]
        if not schema.get(least, 0) <= len(value) <= schema.get(most, len(value)):
            found.append(f"{where}: too short or too long")
    return found + content_errors(value, schema, where)


def content_errors(value, schema, where):
    """The errors in the items of a list or table."""
    found = []
    if isinstance(value, list):
        items = schema.get("items", {})
        known = value[: len(items)] if isinstance(items, list) else value  # a longer list is an error already
        for n, item in enumerate(known):
            found += schema_errors(item, items[n] if isinstance(items, list) else items, f"{where}.{n + 1}")
    if isinstance(value, dict):
        found += [f"{where}: {key} is missing" for key in schema.get("required", ()) if key not in value]
        for key, item in value.items():
            own, other = schema.get("properties", {}), schema.get("additionalProperties", True)
            if key not in own and other is False:
                found.append(f"{where}: {key} is unknown")
            elif key in own or isinstance(other, dict):
                found += schema_errors(item, own.get(key, other), f"{where}.{key}")
    return found


@pytest.mark.parametrize("path", sorted(PATCHES.glob("*/show.toml")) + sorted(PATCHES.glob("*.toml")), ids=str)
def test_project_patches_match_the_schema(path):
    patch, sources = read_sources(path)  # with what the folder beside it adds
    assert schema_errors(sources.data) == []
    assert patch.group


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("tempo = 3", "patch: tempo is unknown"),
        ("seed = -1", "patch.seed: out of range"),
        ("[stage]\nwidht = 3", "patch.stage: widht is unknown"),
        ('[clock]\npriority = ["moon"]', "patch.clock.priority.1: not one of those"),
        ("[camera]\neye = [0, 0]", "patch.camera.eye: too short or too long"),
        ("[camera]\neye = [0, 0, 5000]", "patch.camera.eye.3: out of range"),
        ('[[element]]\nkind = "explode"\nmeasure = 1', "patch.element.1.kind: not one of those"),
        ('[[element]]\nkind = "flock"', "patch.element.1: measure is missing"),
        ('[[formation]]\nname = "a"\nshap = "line"', "patch.formation.1: shap is unknown"),
        ('[[group]]\nname = "a"\ndancers = 0\n[group.motion]\nhed = 1', "patch.group.1.motion: hed is unknown"),
    ],
)
def test_schema_refuses_values_that_the_reader_refuses(text, fault):
    assert fault in schema_errors(tomllib.loads(text))


def test_every_schema_key_has_a_description():
    for name, table in (("", SCHEMA), *SCHEMA["definitions"].items()):
        assert table.get("description"), name
        for key, field in table["properties"].items():
            told = field.get("description") or key in Patch.model_fields
            assert told, f"{name}.{key}"
    assert SCHEMA["properties"]["formation"]["items"]["properties"]["shape"]["description"]


@pytest.mark.long
def test_schema_command_prints_or_writes_the_schema(tmp_path):
    runner = CliRunner()
    printed = runner.invoke(app, ["schema"])
    assert json.loads(printed.stdout) == json.loads(json.dumps(SCHEMA))
    assert runner.invoke(app, ["schema", "--out", str(tmp_path / "s.json")]).exit_code == 0
    assert (tmp_path / "s.json").read_text() == printed.stdout
    assert runner.invoke(app, ["schema", "--out", str(tmp_path / "no" / "s.json")]).exit_code != 0


class _Told(Section):
    model_config = ConfigDict(use_attribute_docstrings=True)
    one: int = 1
    """A number.

    Written on several lines.
    """
    two: int = 2
    three: int = 3
    """The
    last."""


def test_field_docs_are_what_pydantic_reads_from_the_same_source():
    read = {name: field.description for name, field in _Told.model_fields.items() if field.description}
    assert field_docs(_Told) == read == {"one": "A number.\n\nWritten on several lines.", "three": "The\nlast."}


def test_models_are_made_without_reading_sources():
    assert not Section.model_config.get("use_attribute_docstrings")
    assert all(field.description is None for field in Patch.model_fields.values())
