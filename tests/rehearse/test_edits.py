"""PatchEditor: valid edits load and invalid ones are refused, for a file and a folder; the original is unchanged."""

import pytest

from live.base.errors import PersonError
from live.rehearse.fault_injection import INVALID_TABLES, VALID_TABLES, PatchEditor
from live.show.patch.patch_reader import read_patch
from live.show.patch.patch_search_path import find_patch


@pytest.mark.parametrize("name", [None, "score"])
@pytest.mark.parametrize("table", VALID_TABLES)
def test_every_valid_edit_is_a_valid_patch(name, table, tmp_path):
    edits = PatchEditor(find_patch(name), tmp_path / "patch", 1)
    edits._save("good", f"{edits._text}\n{table.format(n=3, a=2.0, b=0.25)}")
    assert read_patch(edits.path) != read_patch(find_patch(name))


@pytest.mark.parametrize(
    "table", [table for table in INVALID_TABLES if "no such step" not in table and "1e-9" not in table]
)
def test_every_invalid_edit_is_refused(table, tmp_path):
    edits = PatchEditor(find_patch("score"), tmp_path / "patch", 1)
    edits._save("bad", f"{edits._text}\n{table}")
    with pytest.raises(PersonError):
        read_patch(edits.path)


def test_original_patch_is_unchanged_and_restored(tmp_path):
    before = find_patch("score").read_bytes()
    edits = PatchEditor(find_patch("score"), tmp_path / "patch", 2)
    for _ in range(20):
        edits.save_valid()
        edits.save_invalid()
    edits.restore()
    assert edits.path.read_bytes() == before == find_patch("score").read_bytes()
    assert edits.edit_counts == {"good": 20, "bad": 20, "back": 1}
