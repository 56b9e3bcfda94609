"""Contact sheets: selection of moments and layout."""

from pathlib import Path

import numpy as np
import pytest

from live.app.offline.sheet_moments import MomentSelector, SheetMoment, moments_of_patch
from live.app.pictures.sheet_picture import DARK, LIGHT, Paper, Sheet, to_srgb
from live.app.session_audio import AudioChoice
from live.cli.inspect.contact_sheet import _measures_between
from live.clock.ticks import TICK
from live.show.loader import LoadedShow, load_show
from live.show.patch.patch_search_path import find_patch

SIZE = (160, 90)


@pytest.fixture(scope="module")
def loaded() -> LoadedShow:
    """A show of a score of two groups."""
    return load_show(find_patch("score"))


def test_sheet_contains_one_described_picture_per_measure(loaded: LoadedShow) -> None:
    show = loaded.start(seed=1, tempo=240.0)
    found = [taken for _, taken in moments_of_patch(loaded, show, AudioChoice(), 8.0, 2) if taken is not None]
    assert [taken.measure for taken in found] == list(range(1, 2 * len(found), 2))
    assert len(found) >= 3
    assert {taken.beat for taken in found} == {3}
    assert found[0].section == loaded.patch.section[0].name
    for taken in found:
        assert [name for _, name, _ in taken.steps] == [group.name for group in loaded.patch.group]
        assert all(step in show.graph.library.steps for _, _, step in taken.steps)
    apart = np.diff([taken.seconds for taken in found])
    assert apart == pytest.approx(2 * 4 * 60 / found[-1].tempo, rel=0.1)


@pytest.mark.long
def test_answering_group_shows_steps_of_its_leader(loaded: LoadedShow) -> None:
    show = load_show(find_patch("partner")).start(seed=1)
    answering = show.dancers.partner_response
    assert answering is not None
    taking, answers = MomentSelector(show, 1, 0), 0
    for tick in range(1, round(14.0 / TICK)):
        show.tick(tick * TICK)
        found = taking.select(tick * TICK)
        if found is not None and found[1] is not None:
            told = {group: step for _, group, step in found[1].steps}
            assert told["leader"] in show.graph.library.steps
            answer = (
                [answering.leaders.recent_units[-1][2]] if answering.path.answering.any() else show.graph.library.steps
            )
            assert told["answer"] in answer
            answers += bool(answering.path.answering.any())
    assert answers >= 3


@pytest.mark.long
def test_trail_frames_are_drawn_before_moment_only_with_trails(loaded: LoadedShow) -> None:
    for trails in (0.0, 0.7):
        show = loaded.start(seed=1, tempo=240.0)
        from live.base.picture_parameters import BY_ADDRESS

        show.desk.parameters.value[BY_ADDRESS["/dance/pass/trails"].first] = trails
        taking = MomentSelector(show, 1, 0)
        drawn = []
        for tick in range(1, 160):
            show.tick(tick * TICK)
            found = taking.select(tick * TICK)
            if found is not None:
                drawn.append((found[1] is not None, show.danced_beats))
        taken = [beat for is_taken, beat in drawn if is_taken]
        assert taken[:2] == pytest.approx([2.2, 6.2], abs=0.1)
        before = [beat for is_taken, beat in drawn if not is_taken and 4.0 < beat < 6.2]
        assert (len(before) >= 4) == (trails > 0.0)


def make_moment(measure: int, **said: object) -> SheetMoment:
    known: dict[str, object] = {
        "measure": measure, "beat": 3, "seconds": 65.0, "tempo": 118.0, "section": "verse", "cue": None,
        "steps": (((1.0, 0.2, 0.0), "ember", "side step"), ((0.0, 0.2, 1.0), "tide", "a step with a very long name")),
    }  # fmt: skip
    return SheetMoment(**(known | said))  # type: ignore[arg-type]


@pytest.mark.parametrize("paper", [DARK, LIGHT])
@pytest.mark.parametrize(("count", "columns"), [(1, 4), (5, 3), (6, 3)])
def test_pictures_lie_unchanged_in_rows(paper: Paper, count: int, columns: int) -> None:
    pictures = [
        (np.random.default_rng(n).integers(0, 255, (SIZE[1], SIZE[0], 3), np.uint8), make_moment(n + 1))
        for n in range(count)
    ]
    sheet = Sheet(SIZE, columns, paper)
    image = np.asarray(sheet.draw(pictures, "A show with a long name, äöü", "1:05"))
    assert image.shape[:2] == sheet.size_for(count)[::-1]
    assert (image[:3] == paper.ground).all()
    assert (image[:, :8] == paper.ground).all()
    assert (image[:, -8:] == paper.ground).all()
    assert (image[-8:] == paper.ground).all()
    places = []
    for picture, _ in pictures:
        corner = np.argwhere((image[: -SIZE[1], : -SIZE[0]] == picture[0, 0]).all(axis=2))
        (at,) = [(y, x) for y, x in corner if np.array_equal(image[y : y + SIZE[1], x : x + SIZE[0]], picture)]
        places.append(at)
    assert places == sorted(places), "row by row"
    assert len({x for _, x in places}) == min(columns, count)


@pytest.mark.long
def test_texts_never_overlap_neighboring_columns() -> None:
    """Every text stays under its own picture: the gaps between the columns are empty."""
    black = np.zeros((SIZE[1], SIZE[0], 3), np.uint8)
    long = "x" * 200
    many = tuple(((0.5, 0.5, 0.5), f"group {n} {long}", long) for n in range(5))
    one = make_moment(123456, section=long, cue=long, steps=many)
    sheet = Sheet(SIZE, 2, LIGHT)
    image = np.asarray(sheet.draw([(black, one), (black, one)], "title", "told"))
    (corner_y,), (corner_x,) = (
        np.flatnonzero((image == 0).all(axis=2).mean(axis=1 - axis) > 0.5)[:1] for axis in (0, 1)
    )
    gap = image[corner_y:, corner_x + SIZE[0] : corner_x + SIZE[0] + round(2.2 * SIZE[0] / 40)]
    assert (gap == LIGHT.ground).all()


def test_colors_match_screen_colors() -> None:
    assert to_srgb((0.0, 1.0, 0.2140)) == (0, 255, 127)
    assert to_srgb((-1.0, 7.0, 0.5)) == (0, 255, 188)


def test_long_shows_use_fewer_measures_per_sheet(tmp_path: Path) -> None:
    assert [_measures_between(count) for count in (1, 24, 25, 48, 49, 1000)] == [1, 1, 2, 2, 4, 64]
