"""Two pages edit one show at random: in the end both, engine and file agree, and the log gives the same bytes."""

import json
import random
import time
from collections import Counter
from pathlib import Path
from typing import Any, Final

import pytest

from live.document.document import LIST_SECTIONS
from live.document.document_store import DocumentStore
from live.document.edit import Edit
from live.show.patch.patch_reader import read_patch
from tests.app.services.test_document_soak import MOST_ENTRIES, PATCH, gone, smaller
from tests.app.services.test_studio_pages import KEY, Studio
from tests.control.waiting import BUSY
from tests.document.random_edits import random_edit
from tests.end_to_end.browser import browser, needs_browser
from tests.show.patch.edited_night import write_patch_folder

pytestmark = [needs_browser, pytest.mark.browser]
NAMES: Final = ("ana", "bea")
BURST: Final = 6
"""Edits that are on their way at a time, at most."""
COUNT: Final = """(answer) => {
  const word = `WORD ${answer.refused ? "refused" : "taken"}`;
  (window.told ??= {})[word] = (window.told[word] ?? 0) + 1;
}"""


def until(page: Any, expression: str) -> None:
    deadline = time.monotonic() + 30.0 * BUSY
    while not page.evaluate(expression):
        assert time.monotonic() < deadline, f"waited in vain for {expression}"
        page.wait_for_timeout(20)


def opened_page(opened: Any, show: Studio, name: str, errors: list[str]) -> Any:
    page = opened.new_context(viewport={"width": 1280, "height": 800}).new_page()
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.add_init_script(f"localStorage.setItem('live.studio.name', {json.dumps(name)})")
    page.goto(f"http://127.0.0.1:{show.web.port}/studio#key={KEY}")
    until(page, "Boolean(window.studio?.doc.structure.value)")
    return page


def held(page: Any, revision: int) -> Any:
    """The score as a page's model holds it, once it has come to a revision and nothing waits."""
    until(page, f"studio.doc.revision.value === {revision} && !studio.doc.waiting.value.length")
    return page.evaluate("studio.doc.structure.value.score")


@pytest.mark.parametrize(
    ("seed", "edits", "seconds"),
    [pytest.param(3, 60, 0.0, marks=pytest.mark.long), pytest.param(4, 0, 300.0, marks=pytest.mark.soak)],
)
def test_two_pages_that_edit_at_random_end_with_the_same_bytes(
    tmp_path: Path, seed: int, edits: int, seconds: float
) -> None:
    rng = random.Random(seed)
    (tmp_path / "show").mkdir()
    show = Studio(write_patch_folder(tmp_path / "show", PATCH))
    errors: list[str] = []
    told: Counter[str] = Counter()
    try:
        with browser() as (opened, _):
            pages = [opened_page(opened, show, name, errors) for name in NAMES]
            own = DocumentStore(show.path)
            first = {
                names: [dict(own.document.values(entry)) for entry in own.document.entries(names)]
                for names in LIST_SECTIONS
                if own.document.entries(names) and names != ("music", "line")
            }
            end = time.monotonic() + seconds
            sent = 0
            while sent < edits or time.monotonic() < end:
                for _ in range(rng.randrange(1, BURST)):
                    own.refresh()
                    page = rng.choice(pages)
                    chance = rng.random()
                    if chance < 0.1:
                        word = rng.choice(("undo", "undo", "redo"))
                        page.evaluate(f"void studio.doc.{word}().then({COUNT.replace('WORD', word)})")
                        continue
                    crowded = sum(len(own.document.entries(names)) for names in LIST_SECTIONS) > MOST_ENTRIES
                    edit = smaller(rng, own) if crowded and chance < 0.5 else random_edit(rng, own.document)
                    if chance > 0.9:
                        edit = gone(rng, own, first) or edit
                    values = edit.to_json_values()
                    said = {"do": values["do"], "at": values["at"], "value": values.get("value")}
                    page.evaluate(
                        f"void studio.doc.edit({json.dumps(said)}, true).then({COUNT.replace('WORD', 'edit')})"
                    )
                    sent += 1
                for page in pages:
                    until(page, "!studio.doc.waiting.value.length")
            for page in pages:
                for word, count in page.evaluate("window.told ?? {}").items():
                    told[word] += count
            until(pages[0], f"studio.doc.revision.value === {show.service.revision}")
            scores = [held(page, show.service.revision) for page in pages]
            later = held(opened_page(opened, show, "cem", errors), show.service.revision)  # as the engine has it now
            assert scores[0] == scores[1] == later
    finally:
        show.stop()
    print(dict(told), show.service.revision, "revisions")
    assert not errors
    assert told["edit taken"] > (told["edit taken"] + told["edit refused"]) / 4
    assert told["undo taken"] > 0
    store = show.service._store
    assert store is not None
    written = show.path.read_bytes()
    assert "".join("".join(file.texts) for file in store.document.files).encode() == written
    assert store.document.patch == read_patch(show.path)
    assert replayed(tmp_path / "again", store) == written
    assert show.replay_differences() == ()


def replayed(folder: Path, former: DocumentStore) -> bytes:
    """The bytes of a show's file when the edits of its log are made once more, from its first text on."""
    folder.mkdir()
    again = DocumentStore(write_patch_folder(folder, PATCH))
    for revision in former.revisions[1:]:
        if revision.what in ("undo", "redo"):
            again.undo(revision.by, redo=revision.what == "redo")
        else:
            assert revision.edit is not None
            again.edit(Edit(revision.edit.do, revision.edit.at, revision.edit.value, by=revision.by))
        assert again.revision == revision.number
    return again.path.read_bytes()
