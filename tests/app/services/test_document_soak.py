"""Three people edit everything in a running show: it stays valid, file and show agree, and its replay is equal."""

import random
from collections import Counter
from pathlib import Path
from typing import Any

import pytest

from live.document.document import LIST_SECTIONS
from live.document.document_store import DocumentStore
from live.document.edit import Edit
from live.show.patch.patch_reader import read_patch
from live.show.patch.patch_update import split_deferred
from tests.app.services.test_document_service import EditedShow
from tests.document.random_edits import random_edit
from tests.show.patch.edited_night import write_patch_folder

PATCH = """# A show with something of each kind.
name = "busy"
steps = "moves"
[selections]
pair = "1 + 4"
[clock]
bpm = 140
[stage]
width = 12
depth = 9
[look]
haze = 0.2
[[group]]
name = "ember"
dancers = 3
steps = ["groove", "side step"]
[[group]]
name = "tide"
dancers = 3
steps = ["side step", "groove"]
[[formation]]
name = "arrow"
shape = "polyline"
points = [[[-2, 0], [0, 1], [2, 0]]]
[[formation]]
name = "wedge"
shape = "star"
size = [4, 3]
[[section]]
name = "verse"
measures = 8
repeat = 2
[[section]]
name = "chorus"
measures = 6
then = "verse"
[[segment]]
section = "verse"
measure = 2
measures = 2
formation = "arrow"
[[segment]]
section = "chorus"
measure = 1
measures = 2
formation = "wedge"
group = "ember"
[[segment]]
section = "chorus"
measure = 4
path = [[0.0, 0.0], [0.0, -0.5]]
group = "tide"
[[sequence]]
section = "verse"
measure = 5
group = "pair"
steps = ["side step x2"]
[[improvise]]
section = "chorus"
measure = 5
measures = 2
group = "tide"
[[element]]
kind = "attract"
section = "verse"
measure = 5
measures = 2
at = [1.0, 0.4]
[[element]]
kind = "repel"
section = "chorus"
measure = 3
at = [0.0, 0.0]
[[signal]]
name = "hit"
section = "verse"
measure = 3
beat = 2.5
[[signal]]
name = "peak"
curve = "swell"
level = 0.7
[[curve]]
name = "swell"
section = "chorus"
measure = 1
points = [[0, 0.1], [2, 1.0], [4, 0.0]]
[[react]]
to = "curve:swell"
sets = "larger"
high = 0.3
[[react]]
on = "hit"
call = "/dance/motion/larger"
values = [0.2, "tide"]
[[at]]
section = "verse"
measure = 6
beat = 2
call = "/dance/light/level"
values = [0.6]
[[at]]
section = "chorus"
measure = 2
scene = "dusk"
[[scene]]
name = "dusk"
set = { "/dance/light/level" = 0.4, "/dance/motion/larger tide" = 0.1 }
[[cue]]
name = "first"
scene = "dusk"
[[cue]]
name = "second"
section = "chorus"
[[view]]
name = "close"
eye = [0, 2, 6]
[[gate]]
name = "left wing"
at = [-6, 0]
[[gate]]
name = "door"
at = [6, 1]
[[item]]
name = "podium"
form = "steps"
at = [0.0, -3.4]
size = [6.0, 1.2, 1.6]
[[obstacle]]
name = "column"
at = [4, 3]
radius = 0.4
[[music.line]]
time_s = 1.0
measure = 1
[[music.line]]
time_s = 2.8
measure = 2
[[music.phrase]]
measure = 1
name = "A"
[[regroup]]
section = "chorus"
measure = 2
dancers = "3"
group = "tide"
[[midi.map]]
control = "/dance/light/level"
cc = 7
"""
MOST_ENTRIES = 140
"""Number of entries beyond which some are deleted."""


def smaller(rng: random.Random, store: DocumentStore) -> Edit:
    """Return the deletion of an entry of the longest list."""
    document = store.document
    names = max((names for names in LIST_SECTIONS), key=lambda names: len(document.entries(names)))
    return Edit("delete", (*names, rng.randrange(len(document.entries(names))) + 1))


def gone(rng: random.Random, store: DocumentStore, first: dict[tuple[str, ...], list[dict[str, Any]]]) -> Edit | None:
    """Return the insertion of an entry of a kind that is hardly there any more; None if all are."""
    missing = [names for names in first if len(store.document.entries(names)) < len(first[names])]
    if not missing:
        return None
    names = rng.choice(missing)
    values = {key: value for key, value in rng.choice(first[names]).items() if key not in ("section", "group", "then")}
    if "name" in values:
        values["name"] = f"{values['name']} {rng.randrange(1000)}"
    return Edit("insert", names, values)


@pytest.mark.long
@pytest.mark.parametrize(("seed", "edits"), [(1, 60), pytest.param(2, 10_000, marks=pytest.mark.soak)])
def test_three_people_edit_everything_while_the_show_runs(tmp_path: Path, seed: int, edits: int) -> None:
    rng = random.Random(seed)
    show = EditedShow(write_patch_folder(tmp_path, PATCH))
    show.run(0.5)
    own = DocumentStore(show.path)
    first = {
        names: [dict(own.document.values(entry)) for entry in own.document.entries(names)]
        for names in LIST_SECTIONS
        if own.document.entries(names) and names != ("music", "line")
    }
    told: Counter[str] = Counter()
    for number in range(edits):
        own.refresh()
        by, base = rng.choice(("ana", "bea", "cem")), own.revision
        chance = rng.random()
        if chance < 0.08:
            answer = show.undo(by)
        else:
            crowded = sum(len(own.document.entries(names)) for names in LIST_SECTIONS) > MOST_ENTRIES
            edit = smaller(rng, own) if crowded and chance < 0.4 else random_edit(rng, own.document)
            if chance > 0.9:
                edit = gone(rng, own, first) or edit
            late = {"base": max(base - rng.randrange(4), own.revisions[0].number)} if chance > 0.8 else {}
            answer = show.send(edit.to_json_values() | {"by": by} | late)[-1]
            told[f"{edit.at[0]} {'refused' if 'refused' in answer else 'accepted'}"] += 1
        told["refused" if "refused" in answer else "accepted"] += 1
        assert show.service._store is not None
        assert show.service._store.document.patch == read_patch(show.path)
        show.run(0.1 * rng.randrange(4))
        if number % 200 == 199:
            show.run(4.0)  # no edit waits any more
            assert split_deferred(read_patch(show.path), show.show.patch)[0] == show.show.patch
            print(number + 1, told["accepted"], flush=True)
    show.run(4.0)
    assert split_deferred(read_patch(show.path), show.show.patch)[0] == show.show.patch
    assert told["accepted"] > edits / 4
    assert show.replay_differences() == ()
