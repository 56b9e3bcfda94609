"""A document on disk: saved whole or not at all, with a history, among other people and other programs."""

import errno
import json
import random
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from live.base.errors import PersonError
from live.document.document_store import DocumentStore, refused_json_values
from live.document.edit import Edit, EditRefused, parse_edit
from live.document.show_check import ShowCheck
from live.show.patch.patch_reader import read_patch
from tests.document.random_edits import random_edit
from tests.fixtures.mostly_long import mostly_long

TEXT = """# A show for tests.
name = "x"
seed = 3

[[group]]
name = "ember"   # the leaders
dancers = 4
steps = ["groove x2", "turn"]

[[segment]]
measure = 1
formation = "circle"

[[segment]]
measure = 9
formation = "line"
"""


@pytest.fixture
def path(tmp_path: Path) -> Path:
    folder = tmp_path / "show"
    (folder / "score").mkdir(parents=True)
    (folder / "show.toml").write_text(TEXT)
    (folder / "score" / "end.toml").write_text('# Later.\n[[segment]]\nmeasure = 20\nformation = "grid"\n')
    return folder / "show.toml"


def tree(path: Path) -> dict[str, bytes]:
    """Return all files of a show by name, without its history."""
    files = (file for file in path.parent.rglob("*") if file.is_file() and ".history" not in file.parts)
    return {file.relative_to(path.parent).as_posix(): file.read_bytes() for file in files}


def put(store: DocumentStore, at: tuple[str | int, ...], value: Any, by: str = "", base: int | None = None) -> int:
    return store.edit(Edit("set", at, value, by=by, base=base)).revision.number


def test_opening_writes_nothing(path: Path) -> None:
    before = tree(path)
    store = DocumentStore(path)
    assert store.revision == 0
    assert tree(path) == before
    assert not (path.parent / ".history").exists()


def test_an_edit_changes_its_file_only(path: Path) -> None:
    store, before = DocumentStore(path), tree(path)
    assert put(store, ("segment", 3, "measure"), 24) == 1
    assert tree(path) == before | {"score/end.toml": before["score/end.toml"].replace(b"20", b"24")}
    assert read_patch(path) == store.document.patch


def test_a_byte_order_mark_and_line_ends_stay(path: Path) -> None:
    path.write_bytes(b"\xef\xbb\xbf" + TEXT.replace("\n", "\r\n").encode())
    put(DocumentStore(path), ("seed",), 4)
    assert path.read_bytes() == b"\xef\xbb\xbf" + TEXT.replace("seed = 3", "seed = 4").replace("\n", "\r\n").encode()


def test_the_history_outlives_the_program(path: Path) -> None:
    before = tree(path)
    for number, value in enumerate((4, 5, 6), start=1):
        assert put(DocumentStore(path), ("seed",), value, by="ana") == number
    store = DocumentStore(path)
    assert [revision.text for revision in store.revisions[1:]] == ["set seed 4", "set seed 5", "set seed 6"]
    assert store.undo("ana").revision.number == 4
    store.restore(0)
    assert tree(path) == before
    DocumentStore(path).restore(2)
    assert read_patch(path).seed == 5


def test_undo_and_redo_are_those_of_one_person(path: Path) -> None:
    store, before = DocumentStore(path), tree(path)
    put(store, ("seed",), 4, by="ana")
    put(store, ("segment", 1, "measures"), 3, by="bea")
    put(store, ("name",), "y", by="ana")
    store.undo("ana")
    store.undo("ana")
    assert (store.document.patch.name, store.document.patch.seed) == ("x", 3)
    assert store.document.patch.segment[0].measures == 3
    with pytest.raises(EditRefused, match="'ana' has nothing to undo"):
        store.undo("ana")
    store.undo("ana", redo=True)
    assert (store.document.patch.name, store.document.patch.seed) == ("x", 4)
    store.undo("ana", redo=True)
    assert store.document.patch.name == "y"
    with pytest.raises(EditRefused, match="nothing to redo"):
        store.undo("ana", redo=True)
    store.undo("ana")
    put(store, ("seed",), 8, by="ana")
    with pytest.raises(EditRefused, match="nothing to redo"):
        store.undo("ana", redo=True)
    store.undo("ana")
    store.undo("ana")
    store.undo("bea")
    assert tree(path) == before


def test_an_undo_after_others_built_on_it_is_refused_with_their_name(path: Path) -> None:
    store = DocumentStore(path)
    put(store, ("segment", 1, "measures"), 3, by="ana")
    put(store, ("segment", 1, "measures"), 2, by="bea")
    with pytest.raises(EditRefused, match="bea changed it meanwhile, in revision 2"):
        store.undo("ana")
    store.undo("bea")
    store.undo("ana")
    assert store.document.patch.segment[0].measures == 4


def test_an_undo_of_a_changed_entry_takes_back_its_own_keys(path: Path) -> None:
    store = DocumentStore(path)
    put(store, ("segment", 1, "measures"), 3, by="ana")
    put(store, ("segment", 1, "formation"), "star", by="bea")
    store.edit(Edit("delete", ("segment", 2), by="bea"))
    store.undo("ana")
    segments = store.document.patch.segment
    assert [(one.measure, one.measures, one.formation) for one in segments] == [(1, 4, "star"), (20, 4, "grid")]


def test_two_people_change_one_segment_in_the_same_moment(path: Path) -> None:
    store = DocumentStore(path)
    put(store, ("segment", 1, "measures"), 3, by="ana", base=0)
    put(store, ("segment", 1, "formation"), "star", by="bea", base=0)  # another key: both are right
    with pytest.raises(EditRefused, match="ana changed it meanwhile, in revision 1") as caught:
        put(store, ("segment", 1, "measures"), 2, by="bea", base=0)
    answer = refused_json_values("b1", caught.value)
    assert answer["id"] == "b1"
    assert set(answer["refused"][0]) == {"file", "line", "field", "what", "remedy", "measure", "dancers"}
    put(store, ("segment", 1, "measures"), 2, by="ana", base=0)  # her own changes are no surprise to her


def test_numbers_mean_the_entries_of_the_revision_that_was_seen(path: Path) -> None:
    store = DocumentStore(path)
    store.edit(Edit("insert", ("segment", 1), {"measure": 30}, by="ana"))
    put(store, ("segment", 2, "measures"), 2, by="bea", base=0)  # the one at measure 9, which is number 3 now
    assert [(one.measure, one.measures) for one in store.document.patch.segment] == [(30, 4), (1, 4), (9, 2), (20, 4)]
    store.edit(Edit("delete", ("segment", 2), by="ana"))
    with pytest.raises(EditRefused, match="ana removed it meanwhile"):
        put(store, ("segment", 1, "measures"), 2, by="bea", base=0)
    with pytest.raises(EditRefused, match="there is no revision 99"):
        put(store, ("seed",), 2, base=99)


def test_an_entry_that_was_removed_and_given_back_meanwhile_can_be_edited(path: Path) -> None:
    store = DocumentStore(path)
    store.edit(Edit("delete", ("segment", 1), by="ana"))
    with pytest.raises(EditRefused, match="ana removed it meanwhile, in revision 1"):
        put(store, ("segment", 1, "formation"), "star", by="bea", base=0)
    store.undo("ana")
    put(store, ("segment", 1, "formation"), "star", by="bea", base=0)
    assert [one.formation for one in read_patch(path).segment] == ["star", "line", "grid"]


def test_what_another_program_writes_is_taken_in_and_kept(path: Path) -> None:
    store = DocumentStore(path)
    put(store, ("seed",), 4, by="ana")
    path.write_text(path.read_text().replace('name = "x"', 'name = "y" # by hand'))
    put(store, ("segment", 1, "measures"), 2, by="ana")
    assert 'name = "y" # by hand' in path.read_text()
    assert [revision.what for revision in store.revisions] == ["files", "edit", "files", "edit"]
    with pytest.raises(EditRefused, match="another program changed the document since"):
        put(store, ("segment", 1, "measures"), 3, by="ana", base=1)
    store.undo("ana")
    store.undo("ana")
    assert path.read_text() == TEXT.replace('name = "x"', 'name = "y" # by hand')
    store.restore(1)
    assert path.read_text() == TEXT.replace("seed = 3", "seed = 4")


def test_changes_while_no_program_ran_are_known_from_the_copies(path: Path) -> None:
    put(DocumentStore(path), ("seed",), 4)
    (path.parent / "looks").mkdir()
    (path.parent / "looks" / "warm.toml").write_text('[[looks]]\nname = "warm"\n')
    (path.parent / "score" / "end.toml").unlink()
    store = DocumentStore(path)
    assert store.revisions[-1].text == "another program changed looks/warm.toml, score/end.toml"
    store.restore(1)
    assert set(tree(path)) == {"show.toml", "score/end.toml"}
    store.restore(2)
    assert set(tree(path)) == {"show.toml", "looks/warm.toml"}


def test_an_invalid_file_of_another_program_is_told_and_never_overwritten(path: Path) -> None:
    store = DocumentStore(path)
    path.write_text("name = \n")
    with pytest.raises(EditRefused, match=r"another program changed the files, and they are not valid now.*line 1"):
        put(store, ("seed",), 4)
    assert path.read_text() == "name = \n"
    path.write_text(TEXT)
    put(store, ("seed",), 4)
    assert path.read_text() == TEXT.replace("seed = 3", "seed = 4")


def test_a_file_changed_in_the_middle_of_an_edit_is_not_overwritten(path: Path) -> None:
    changed = TEXT.replace("dancers = 4", "dancers = 5")

    def check(_patch: object, _former: object) -> list[PersonError]:
        path.write_text(changed)  # while the edit is being checked
        return []

    store = DocumentStore(path, check=check)
    with pytest.raises(EditRefused, match="another program changed the files in this moment"):
        put(store, ("seed",), 4)
    assert path.read_text() == changed
    store.check = None
    put(store, ("seed",), 4)
    assert path.read_text() == changed.replace("seed = 3", "seed = 4")


def test_a_damaged_history_begins_anew(path: Path) -> None:
    store = DocumentStore(path)
    put(store, ("seed",), 4)
    put(store, ("seed",), 5)
    log = path.parent / ".history" / "show.jsonl"
    lines = log.read_bytes().splitlines(keepends=True)
    log.write_bytes(b"".join(lines)[:-20])  # the last line is cut off: its edit counts as another program's
    store = DocumentStore(path)
    assert [revision.what for revision in store.revisions] == ["files"]
    assert put(store, ("seed",), 6) == store.revision
    assert DocumentStore(path).revisions == store.revisions
    log.write_bytes(b"\xff{}\n[1]\n")
    assert put(DocumentStore(path), ("seed",), 7) == 1


def test_an_edit_that_cannot_be_locked_against_others_is_refused(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    store, before = DocumentStore(path), path.read_text()

    def fail(*_: Any, **__: Any) -> None:
        raise OSError(errno.EIO, "Input/output error")

    monkeypatch.setattr("live.base.system.file_lock._lock", fail)
    with pytest.raises(EditRefused, match="cannot be saved"):
        put(store, ("seed",), 4)
    assert path.read_text() == before


@pytest.mark.long
def test_a_full_disk_leaves_the_old_files_whole(path: Path) -> None:
    """The limit on a file's size makes the system refuse the write, as a full disk does."""
    program = """
import resource, signal, sys
from pathlib import Path
from live.document.document_store import DocumentStore
from live.document.edit import Edit, EditRefused
store = DocumentStore(Path(sys.argv[1]))
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
for limit in (0, 100, 400, 600, 700, 800):
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))
    try:
        store.edit(Edit("set", ("seed",), 5))
    except EditRefused as error:
        assert "cannot be saved" in str(error), error
        print("refused", store.revision, store.document.patch.seed)
    else:
        print("saved")
        break
    resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
    assert Path(sys.argv[1]).read_text().count("seed = 3") == 1
"""
    before = tree(path)
    found = subprocess.run([sys.executable, "-c", program, str(path)], capture_output=True, text=True, timeout=120)
    assert found.returncode == 0, found.stderr
    lines = found.stdout.splitlines()
    assert lines[:2] == ["refused 0 3", "refused 0 3"]
    if "saved" not in lines:
        assert tree(path) == before


def test_a_patch_of_fifty_megabytes_is_refused_before_it_is_read(path: Path) -> None:
    path.write_bytes(b"#" * 50_000_000)
    with pytest.raises(PersonError, match="a patch has at most"):
        DocumentStore(path)


@pytest.mark.long
def test_edits_pass_the_checks_of_the_show(path: Path) -> None:
    store = DocumentStore(path, check=ShowCheck(path))
    with pytest.raises(EditRefused) as caught:
        put(store, ("group", "ember", "steps"), ["no step"])
    (fault,) = caught.value.faults
    assert (fault.field, fault.line) == ("group.1.steps", 8)
    for number in (1, 2):
        edit = Edit("insert", ("segment", number), {"measure": number * 30, "formation": f"nothing{number}"})
        with pytest.raises(EditRefused, match="nothing"):
            store.edit(edit)
    put(store, ("group", "ember", "steps"), ["bow"])
    assert read_patch(path).group[0].steps == ("bow",)


@pytest.mark.parametrize(
    ("tables", "edit"),
    [
        ('[[midi.map]]\ncontrol = "/dance/light/level"\ncc = 7\n', Edit("set", ("midi", "map", 1, "cc"))),
        ('[picture]\npasses = ["bloom"]\n', Edit("set", ("picture", "passes"), ["bloom", "no such pass"])),
        ("[stage]\nwidth = 9\n", Edit("set", ("stage", "width"), -1)),
    ],
)
def test_tables_that_are_no_list_of_their_own_pass_their_checks(path: Path, tables: str, edit: Edit) -> None:
    path.write_text(TEXT + tables)
    store = DocumentStore(path)
    with pytest.raises(EditRefused):
        store.edit(edit)
    assert path.read_text() == TEXT + tables


@pytest.mark.long
def test_a_refusal_by_the_show_lists_all_its_entries(path: Path) -> None:
    """Each segment that names a formation which is gone is a fault of its own."""
    text = TEXT + '[[formation]]\nname = "wedge"\nshape = "grid"\n'
    text += "".join(f'[[segment]]\nmeasure = {40 + 8 * n}\nformation = "wedge"\n' for n in range(3))
    path.write_text(text)
    store = DocumentStore(path, check=ShowCheck(path))
    with pytest.raises(EditRefused) as caught:
        store.edit(Edit("delete", ("formation", "wedge")))
    assert [fault.field.split(".")[1] for fault in caught.value.faults] == ["3", "4", "5"]
    assert [fault.measure for fault in caught.value.faults] == [40, 48, 56]


@mostly_long("seed", range(3), quick=[])
def test_random_edits_by_three_people_keep_document_files_and_history_alike(path: Path, seed: int) -> None:
    rng, store = random.Random(seed), DocumentStore(path)
    texts = {0: tree(path)}
    for _ in range(60):
        by = rng.choice(("ana", "bea", "cem"))
        try:
            if rng.random() < 0.25:
                store.undo(by, redo=rng.random() < 0.3)
            else:
                edit = random_edit(rng, store.document, by)
                base = rng.choice((None, max(store.revision - rng.randrange(3), 0)))
                store.edit(Edit(edit.do, edit.at, edit.value, by=by, base=base))
        except EditRefused:
            pass
        assert read_patch(path) == store.document.patch
        texts.setdefault(store.revision, tree(path))
        assert texts[store.revision] == tree(path)
    assert len(texts) > 25
    assert DocumentStore(path).revisions == store.revisions
    for number in rng.sample(sorted(texts), 5):
        store.restore(number)
        assert tree(path) == texts[number]


def test_an_inverse_that_was_sent_back_gives_the_bytes(path: Path) -> None:
    store, before = DocumentStore(path), tree(path)
    answers = [
        store.edit(edit).to_json_values("e")
        for edit in (
            Edit("rename", ("group", "ember"), "glow"),
            Edit("delete", ("segment", 2)),
            Edit("copy", ("segment", 1), 50),
            Edit("set", ("stage", "width"), 12.5),
        )
    ]
    for answer in reversed(json.loads(json.dumps(answers))):
        store.edit(parse_edit(answer["inverse"]))
    assert tree(path) == before


def test_two_programs_edit_one_show(path: Path) -> None:
    """The running show and the command line: each takes in the revisions of the other."""
    one, other = DocumentStore(path), DocumentStore(path)
    put(one, ("seed",), 4, by="ana")
    put(other, ("segment", 1, "measures"), 3, by="bea")
    put(one, ("name",), "y", by="ana")
    other.undo("ana")
    assert [revision.number for revision in DocumentStore(path).revisions] == [0, 1, 2, 3, 4]
    assert one.refresh()
    assert one.revisions == other.revisions
    one.restore(0)
    assert path.read_text() == TEXT


def together(edits: list[dict[str, Any]], **more: Any) -> Edit:
    return parse_edit({"do": "together", "edits": edits, **more})


def test_edits_together_are_one_revision_and_are_undone_as_one(path: Path) -> None:
    store, before = DocumentStore(path), tree(path)
    edits = [
        {"do": "delete", "at": ["segment", 1]},
        {"do": "move", "at": ["segment", 1], "value": 12},
        {"do": "insert", "at": ["segment"], "value": {"measure": 30, "formation": "star"}},
    ]
    assert store.edit(together(edits, by="ana")).revision.number == 1
    assert [one.measure for one in store.document.patch.segment] == [12, 20, 30]
    store.edit(Edit("set", ("group", "ember", "dancers"), 5, by="ben"))
    store.undo("ana")
    store.undo("ben")
    assert tree(path) == before
    with pytest.raises(EditRefused):  # the second cannot be: the first is not either
        store.edit(together([{"do": "set", "at": ["seed"], "value": 9}, {"do": "set", "at": ["seed"], "value": "x"}]))
    assert tree(path) == before
    patch, answers = store.attempt([together(edits, id=4)])
    assert (len(patch.segment), answers[0]["id"], len(store.document.patch.segment)) == (3, 4, 3)
    assert tree(path) == before


def test_edits_together_mean_what_their_sender_saw(path: Path) -> None:
    store = DocumentStore(path)
    seen = store.revision
    store.edit(Edit("insert", ("segment", 1), {"measure": 5, "formation": "star"}, by="ben"))
    moves = [{"do": "move", "at": ["segment", number], "value": 10 + number} for number in (1, 2)]
    store.edit(together(moves, by="ana", base=seen))
    assert [one.measure for one in store.document.patch.segment] == [5, 11, 12, 20]
    with pytest.raises(EditRefused, match="look again"):
        store.edit(together([{"do": "delete", "at": ["segment", 1]}, moves[1]], by="ana", base=seen))


@pytest.mark.parametrize(
    "edits",
    [
        [], {}, [7], [{"do": "together", "edits": []}], [{"do": "set", "at": ["seed"], "base": 4}],
        [{"do": "set", "at": []}], [{"do": "delete", "at": ["segment", 1]}] * 1001,
    ],
)  # fmt: skip
def test_edits_together_that_are_none_are_refused(edits: Any) -> None:
    with pytest.raises(PersonError):
        parse_edit({"do": "together", "edits": edits})
