"""The reference docs/patch.md matches the schema, and every key is explained."""

import importlib.util

from live.show.patch.patch import Patch
from tests.places import ROOT


def _load_tool(name="write_patch_reference"):
    spec = importlib.util.spec_from_file_location(name, ROOT / "tools" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_reference_is_up_to_date():
    assert (ROOT / "docs" / "patch.md").read_text(encoding="utf-8") == _load_tool().reference()


def test_reference_lists_every_key_with_a_description():
    rows = [line for line in _load_tool().reference().splitlines() if line.startswith("| `")]
    assert len(rows) >= 30
    assert all(len(row.split("|")[4].strip()) > 5 for row in rows), [
        r for r in rows if len(r.split("|")[4].strip()) < 6
    ]
    for key in Patch.model_fields:
        assert f"`{key}`" in _load_tool().reference() or f"[{key}]" in _load_tool().reference()


def test_forms_of_the_studio_are_up_to_date():
    tool = _load_tool("write_studio_schema")
    assert tool.OUT.read_text(encoding="utf-8") == tool.text(), "python tools/write_studio_schema.py"
    fields = [field for kind in tool.studio_schema().values() for field in kind]
    assert all(field["help"] for field in fields)
    for kind, first in tool.FIRST.items():
        assert {*first} <= {field["key"] for field in tool.studio_schema()[kind]}, kind
