"""The reference of patch files lists every key with an explanation; the studio's forms match the schema."""

import importlib.util

from live.show.patch.patch import Patch
from tests.places import ROOT
from tools.reference.patch_pages import patch_pages


def _load_tool(name):
    spec = importlib.util.spec_from_file_location(name, ROOT / "tools" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_reference_lists_every_key_with_a_description():
    pages = patch_pages()
    rows = [line for text in pages.values() for line in text.splitlines() if line.startswith("| `")]
    assert len(rows) >= 300
    assert all(len(row.split("|")[4].strip()) > 5 for row in rows), [
        r for r in rows if len(r.split("|")[4].strip()) < 6
    ]
    for key in Patch.model_fields:
        assert f"{key}.md" in pages or f"`{key}`" in pages["index.md"]


def test_forms_of_the_studio_are_up_to_date():
    tool = _load_tool("write_studio_schema")
    assert tool.OUT.read_text(encoding="utf-8") == tool.text(), "python tools/write_studio_schema.py"
    schema = tool.studio_schema()
    fields = [field for kind in schema.values() for field in kind]
    assert all(field["help"] for field in fields)
    for kind, first in tool.FIRST.items():
        assert {*first} <= {field["key"] for field in schema[kind]}, kind
