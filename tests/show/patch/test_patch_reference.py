"""docs/patch.md says what the schema says, and every key is explained."""

import importlib.util

from live.show.patch.patch import Patch
from tests.places import ROOT


def _tool():
    spec = importlib.util.spec_from_file_location("write_patch_reference", ROOT / "tools" / "write_patch_reference.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_reference_is_up_to_date():
    assert (ROOT / "docs" / "patch.md").read_text(encoding="utf-8") == _tool().reference()


def test_every_key_is_in_it_with_a_word_on_what_it_is_for():
    rows = [line for line in _tool().reference().splitlines() if line.startswith("| `")]
    assert len(rows) >= 30
    assert all(len(row.split("|")[4].strip()) > 5 for row in rows), [
        r for r in rows if len(r.split("|")[4].strip()) < 6
    ]
    for key in Patch.model_fields:
        assert f"`{key}`" in _tool().reference() or f"[{key}]" in _tool().reference()
