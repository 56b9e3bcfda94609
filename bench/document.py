"""Edits of a show's files: from the edit to the saved file, to the running show's agreement, and to pages."""

import gc
import random
import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from bench import _studio_rows
from bench._document_score import score_text
from live.cli.bench import Row
from live.document.document_store import DocumentStore
from live.document.edit import Edit, EditRefused
from live.document.preview import PreviewEngine
from live.document.show_check import ShowCheck
from live.show.loader import load_show
from live.show.patch.patch_reader import read_patch

MEASURES = 5000


def run(full: bool, shared: Path | None) -> list[Row]:
    """One core; medians of CPU time, without automatic garbage collection, as in a running show.

    The peer is the reading of the whole patch, which an edit used to need.
    """
    gc.collect()
    gc.freeze()
    gc.disable()
    try:
        return _rows(200 if full else 40, 15 if full else 1)
    finally:
        gc.enable()
        gc.unfreeze()


def _rows(count: int, blocks: int) -> list[Row]:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "show.toml"
        path.write_text(score_text(MEASURES))
        whole = _median(lambda: read_patch(path), 5)
        store = DocumentStore(path)
        edits = list(_edits(count))
        saved = _times(store, edits)
        undone = _median(store.undo, count // 2)
        check = ShowCheck(path)
        store = DocumentStore(path, check=check)
        check(store.document.patch, None)
        accepted = _times(store, list(_edits(count, seed=2)))
        renamed = _times(
            store, [Edit("rename", ("group", "ember"), "glow"), Edit("rename", ("group", "glow"), "ember")]
        )
        preview = _preview_times(Path(folder))
        studio = _studio_rows.rows(Path(folder), blocks)
    where = f"a score of {MEASURES:,} measures"
    return [
        Row(f"{where}: edit to saved file, CPU", saved, "ms", 10.0),
        Row(f"{where}: reading it whole / an edit", whole / saved, "", 1.0, "at least", {"read_patch, ms": whole}),
        Row(f"{where}: undo to saved file, CPU", undone, "ms"),
        Row(f"{where}: edit to accepted and saved, with the show's checks, CPU", accepted, "ms", 50.0),
        Row(f"{where}: a group's new name in 1,250 entries, accepted and saved, CPU", renamed, "ms"),
        *preview,
        *studio,
    ]


def _preview_times(folder: Path) -> list[Row]:
    """A score of 64 measures and 50 dancers, simulated aside."""
    path = folder / "short.toml"
    path.write_text(score_text(64))
    loaded = load_show(path)
    begin = time.perf_counter()
    engine = PreviewEngine(loaded)
    engine.run_to(64)
    whole = (time.perf_counter() - begin) * 1e3
    rng = random.Random(3)
    scrubbed, planned = [], []
    for _ in range(12):
        begin = time.perf_counter()
        engine.view_at(rng.uniform(0.0, 63.0))
        scrubbed.append((time.perf_counter() - begin) * 1e3)
        index = rng.randrange(len(loaded.patch.segment))
        rows = list(loaded.patch.segment)
        rows[index] = rows[index].model_copy(update={"formation": "star:5"})
        edited = loaded.patch.model_copy(update={"segment": tuple(rows)})
        measure = rows[index].measure
        begin = time.perf_counter()
        engine.plan(measure, measure + rows[index].measures - 1, edited)
        planned.append((time.perf_counter() - begin) * 1e3)
    where = "64 measures of 50 dancers"
    return [
        Row(f"{where}: ways of a changed segment", statistics.median(planned), "ms", 200.0),
        Row(f"{where}: the stage at any measure, from a warm preview", max(scrubbed), "ms", 300.0),
        Row(f"{where}: the whole preview", whole, "ms"),
    ]


def _edits(count: int, seed: int = 1) -> list[Edit]:
    """Return edits of all kinds at random places of the score that are accepted."""
    rng = random.Random(seed)
    made = []
    for number in range(count):
        segment = rng.randrange(1, 1000)
        made.append(
            rng.choice(
                (
                    Edit("set", ("segment", segment, "measures"), rng.randrange(1, 5)),
                    Edit("change", ("segment", segment), {"formation": rng.choice(("grid", "line", "star:5"))}),
                    Edit("copy", ("signal", f"s{8 * rng.randrange(600) + 1}"), {"beat": 3}),
                    Edit("insert", ("at",), {"measure": segment, "call": "/dance/spread", "values": [2]}),
                    Edit("set", ("sequence", segment, "steps", 1), "turn"),
                    Edit("rename", ("signal", f"s{8 * number + 1}"), f"hit {number}"),
                )
            )
        )
    return made


def _times(store: DocumentStore, edits: list[Edit]) -> float:
    """Return the median CPU time of edits that are accepted [ms]."""
    found = []
    for edit in edits:
        begin = time.process_time()
        try:
            store.edit(edit)
        except EditRefused:
            continue
        found.append(time.process_time() - begin)
    if len(found) < len(edits) // 2:
        raise RuntimeError("most edits of the bench were refused")
    return statistics.median(found) * 1e3


def _median(work: Callable[[], object], count: int) -> float:
    found = []
    for _ in range(count):
        begin = time.process_time()
        work()
        found.append(time.process_time() - begin)
    return statistics.median(found) * 1e3
