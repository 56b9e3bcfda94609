"""What dancers' pages say is what a run of the show does that the sheets have no part in."""

import re
from pathlib import Path

import numpy as np
import pytest

from live.clock.ticks import TICK
from live.control.events import events
from live.document.sheets.dancer_pages import dancer_rows
from live.document.sheets.sheet_book import SheetBook
from live.motion.skeleton import SKELETON
from live.show.loader import LoadedShow, load_show
from live.show.patch.patch_search_path import find_patch
from tests.document.sheets.small_show import make_book

pytestmark = pytest.mark.xdist_group("sheets")

NUMBERS = re.compile(r"x ([+−]?[\d.]+), z ([+−]?[\d.]+)")
EXAMPLES = (
    "first_show", "partner", "ballet", "barre", "contemporary", "cues", "folk", "formations", "hiphop", "house",
    "lindy", "pairs", "release", "salsa", "samba", "score", "tap", "waltz",
)  # fmt: skip


def replayed(loaded: LoadedShow, measures: int) -> tuple[np.ndarray, list[list[str]]]:
    """Return where the drawn hips of all are at each measure line, (M + 1, A, 2) [m], and the names of what they
    dance in the middle of each measure. Somebody advances a waiting score in the last measure of the first pass."""
    show = loaded.start()
    view, places, steps, tick, told = show.view(), [], [], 0, set()
    while len(places) <= measures:
        tick += 1
        show.tick(tick * TICK)
        if show.span.number >= len(places):
            show.fill(view, tick * TICK)
            places.append(view.joint_position[: len(show.group), SKELETON.index("hips"), ::2].copy())
            place = show.playhead.place(show.span.number)
            if show.playhead.waiting and show.patch.section and place.section >= 0:
                section = show.patch.section[place.section]
                if place.measure + 1 == section.measures and place.section not in told:
                    told.add(place.section)
                    show.apply(events.Advance(time=tick * TICK, source="person"))
        if len(steps) < len(places) and show.danced_beats / show.desk.beats >= len(steps) + 0.5:
            names = show.graph.library.steps
            steps.append([names[step] for step in show.graph.library.node_step[show.dancers.node]])
    return np.array(places), steps


def check(book: SheetBook, loaded: LoadedShow, measures: int | None = None) -> int:
    """Compare each place and step of all dancers' pages, or of the scenes within the first measures, with a run; return
    how many places were compared."""
    places, steps = replayed(loaded, measures or book.record.measures)
    compared = 0
    for dancer in book.dancers.tolist():
        for row in dancer_rows(book, dancer):
            part, said = row.part, dict(row.lines)
            if part.scene.end >= len(places):
                continue
            for about, measure, there in (
                ("Start", part.scene.first, part.there[0]),
                ("End", part.scene.end, part.there[1]),
            ):
                if about in said and there:
                    found = NUMBERS.search(said[about])
                    assert found is not None
                    at = [float(one.replace("−", "-")) for one in found.groups()]
                    apart = float(np.hypot(*(places[measure, dancer] - at)))
                    assert apart < 0.1, f"dancer {dancer + 1}, {row.title}, {about}: {apart:.2f} m beside it"
                    compared += 1
            if "Steps" in said and "answers" not in said["Steps"]:
                told = [name for name, times in part.steps for _ in range(times)]
                assert told == [steps[measure][dancer] for measure in range(part.scene.first, part.scene.end)]
    return compared


def test_first_scene_is_danced_as_its_pages_say(book: SheetBook, loaded: LoadedShow) -> None:
    assert check(book, loaded, book.scenes[0].end) > 5


@pytest.mark.long
def test_small_show_is_danced_as_its_pages_say(book: SheetBook, loaded: LoadedShow) -> None:
    assert check(book, loaded) > 15


@pytest.mark.long
@pytest.mark.parametrize("name", EXAMPLES)
def test_examples_are_danced_as_their_pages_say(name: str, tmp_path: Path) -> None:
    loaded = load_show(find_patch(name))
    book = make_book(loaded)
    assert check(book, loaded) >= len(book.dancers)
