"""A document gives the patch that the reader gives, and places in its files, after every edit."""

import random
from pathlib import Path

import pytest

from live.base.errors import PersonError
from live.document.document import LIST_SECTIONS, Document
from live.document.edit import Edit, EditRefused
from live.document.edit_actions import apply_edit
from live.show.patch.patch import Patch
from live.show.patch.patch_reader import patch_files, read_patch, read_sources
from live.show.patch.patch_search_path import PATCHES
from live.show.patch.toml_model import TomlSources, parse_text, validate_sources
from live.show.patch_checks.patch_check import PATCH_CHECKS
from tests.document.random_edits import random_edit
from tests.fixtures.mostly_long import mostly_long

SHOWS = sorted({*PATCHES.glob("*.toml"), *PATCHES.glob("*/show.toml")})


def open_document(path: Path) -> Document:
    files = [(file.relative_to(path.parent).as_posix(), file.read_bytes().decode()) for file in patch_files(path)]
    return Document(files, path=path)


def read_again(document: Document) -> Patch:
    """Return the patch of the document's texts as a reader of whole files gives it."""
    sources = TomlSources([parse_text(file.text, file.file, "patch") for file in document.files])
    return validate_sources(sources, Patch, "patch", PATCH_CHECKS)


def test_there_are_ten_patches() -> None:
    assert len(SHOWS) >= 10


@pytest.mark.parametrize("path", SHOWS, ids=lambda path: path.relative_to(PATCHES).as_posix())
def test_a_document_is_the_patch_that_is_read(path: Path) -> None:
    document = open_document(path)
    assert document.patch == read_patch(path)
    assert document.patch.to_json_values() == read_patch(path).to_json_values()


@mostly_long("path", SHOWS, ids=lambda path: path.relative_to(PATCHES).as_posix(), quick=[0, 3, 6, 9, 12, 15])
def test_places_are_those_of_the_whole_text(path: Path) -> None:
    document, (_, sources) = open_document(path), read_sources(path)
    keys: list[tuple[str | int, ...]] = [("stage", "width"), ("clock", "bpm"), ("seed",), ("nothing",)]
    for names in LIST_SECTIONS:
        for number, entry in enumerate(document.entries(names)):
            keys.append((*names, number))
            keys += [(*names, number, key) for key in document.values(entry)]
    assert len(keys) > 10
    for key in keys:
        assert document.location(key) == sources.location(key), key


@mostly_long("path", SHOWS, quick=[15], ids=lambda path: path.relative_to(PATCHES).as_posix())
def test_fifty_random_edits_undone_in_order_give_the_original_bytes(path: Path) -> None:
    """500 edits over ten patches; a refused one leaves everything as it was."""
    rng = random.Random(path.parent.name)
    document = open_document(path)
    original = [file.text for file in document.files]
    done, refused = [], 0
    for _ in range(50):
        before = [file.text for file in document.files]
        edit = random_edit(rng, document)
        try:
            applied = apply_edit(document, edit)
        except EditRefused:
            refused += 1
            assert [file.text for file in document.files] == before
            continue
        assert read_again(document) == document.patch, edit
        assert read_again(document).to_json_values() == document.patch.to_json_values(), edit
        done.append((before, applied))
    assert len(done) > 20
    assert refused > 0
    meant = Document([(file.name, file.text) for file in document.files], path=path)
    for _, applied in reversed(done):  # by meaning alone, without the exact texts
        assert applied.inverse is not None
        apply_edit(meant, applied.inverse)
    for before, applied in reversed(done):
        assert applied.inverse is not None
        exact = tuple(splice.reverse() for splice in reversed(applied.splices))
        apply_edit(document, Edit(applied.inverse.do, applied.inverse.at, applied.inverse.value, exact=exact))
        assert [file.text for file in document.files] == before
    assert [file.text for file in document.files] == original
    assert meant.patch == document.patch


def test_all_faults_of_a_text_are_told_at_once(tmp_path: Path) -> None:
    text = 'name = "x"\n[[group]]\nname = "a"\ndancers = 2\nsteps = ["groove"]\n'
    text += '[[regroup]]\nmeasure = 3\ndancers = "a"\ngroup = "b"\n[[cue]]\nname = "one"\nscene = "none"\n'
    text += '[[cue]]\nname = "two"\nscene = "neither"\n'
    with pytest.raises(PersonError) as caught:
        Document([("show.toml", text)], path=tmp_path / "show.toml")
    assert "line 6: regroup.1.group: " in str(caught.value) or "line 9: regroup.1.group: " in str(caught.value)
    assert "line 12: cue.1.scene: " in str(caught.value)
    assert "line 15: cue.2.scene: " in str(caught.value)


def test_tables_apart_from_their_entry_are_read_and_not_edited(tmp_path: Path) -> None:
    text = 'name = "x"\n[[group]]\nname = "a"\ndancers = 2\nsteps = ["groove"]\n'
    text += "[stage]\nwidth = 9\n[group.motion]\nlarger = 0.25\n"
    document = Document([("show.toml", text)], path=tmp_path / "show.toml")
    assert document.patch.group[0].motion is not None
    assert document.patch.group[0].motion.larger == 0.25
    assert document.location(("group", 0, "motion", "larger"))[1] == 9
    with pytest.raises(EditRefused, match="stands elsewhere in the file"):
        apply_edit(document, Edit("change", ("group", "a"), {"dancers": 3}))
