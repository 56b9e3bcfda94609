"""Springs of characters in a show: the same bits in replays, snapshots and at any frame rate; at rest after a stall."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from live.base.stage_snapshot import StageView
from live.clock.ticks import TICK
from live.show.dancers import character_springs as module
from live.show.dancers.character_casting import character_springs
from live.show.dancers.character_springs import CHOICE_TICKS, FADE_TICKS
from live.show.loader import LoadedShow
from live.show.patch.patch_reader import parse_patch
from live.show.state.snapshot import restore
from tests.render.characters.detailed_figures import HAIR_BONES, STYLES, detailed_glb
from tests.show.made_show import GRAPH, PATCH
from tests.show.state.test_snapshot import capture_from, run

CHARACTERS = """
[[character]]
name = "anna"
file = "anna.glb"
groups = ["front"]
"""


@pytest.fixture
def loaded(tmp_path) -> LoadedShow:
    """A show whose group of five dances as characters with a ponytail, and four as generated bodies."""
    (tmp_path / "anna.glb").write_bytes(detailed_glb(**STYLES["Mixamo"]))
    patch, path = parse_patch(PATCH + CHARACTERS, "a.toml"), tmp_path / "a.toml"
    return LoadedShow(path, patch, GRAPH, springs=character_springs(patch, path))


def ticked(loaded, last, first=1, show=None):
    show = show or loaded.start()
    for tick in range(first, last + 1):
        show.tick(tick * TICK)
    return show


def view_of(show, after=0.0) -> StageView:
    view = show.view()
    show.fill(view, show.time + after)
    return view


def springs_in(view):
    """Rotations (A, B, 4) of all dancers' bones, at rest for those who have none."""
    found = np.zeros((len(view.group), *view.spring.shape[1:]), np.float32)
    found[..., 0] = 1.0
    found[view.spring_slot >= 0] = view.spring[view.spring_slot[view.spring_slot >= 0]]
    return found


def state_of(show):
    """All bits of the springs' state."""
    springs = show.springs
    return [array.tobytes() for array in (springs._now, springs._before, springs._turn, springs._turn_before)]


def angles(turn):
    """How far bones are from rest [rad]."""
    return 2.0 * np.arccos(np.clip(np.abs(turn[..., 0]), 0.0, 1.0))


def test_hair_swings_as_its_dancers_move(loaded):
    view = view_of(ticked(loaded, 300))
    assert view.spring.shape[:1] == (5,)
    assert view.spring.shape[1] >= HAIR_BONES
    assert angles(view.spring).max() > 0.05
    assert angles(view.spring).max() < 2.0
    assert (view.spring_slot[:5] >= 0).all()
    assert (view.spring_slot[5:] < 0).all()  # these are generated bodies
    assert np.allclose(np.linalg.norm(view.spring, axis=-1), 1.0, atol=1e-5)


def test_shows_without_springs_have_none():
    patch = parse_patch(PATCH, "a.toml")
    show = LoadedShow(Path("a.toml"), patch, GRAPH).start()
    show.tick(TICK)
    assert view_of(show).spring.shape == (0, 0, 4)


@pytest.mark.long
def test_frames_change_no_spring(loaded):
    plain, watched = loaded.start(), loaded.start()
    for tick in range(1, 200):
        plain.tick(tick * TICK)
        watched.tick(tick * TICK)
        if tick % 3 == 0:
            view_of(watched, 0.4 * TICK)
    assert state_of(plain) == state_of(watched)
    assert np.array_equal(view_of(plain, 0.003).spring, view_of(watched, 0.003).spring)


@pytest.mark.long
def test_restored_show_swings_on_with_the_same_bits(loaded):
    show = loaded.start()
    run(show, 1, 150, {})
    at, data = capture_from(show, 150, {})
    restored = restore(loaded, data)
    assert np.array_equal(view_of(restored, 0.004).spring, view_of(show, 0.004).spring)
    assert run(restored, at + 1, at + 100, {}) == run(show, at + 1, at + 100, {})
    assert state_of(restored) == state_of(show)


def test_springs_change_nothing_else(loaded):
    """So a replay where the files are gone has the same hashes."""
    assert run(loaded.start(), 1, 200, {}) == run(replace(loaded, springs={}).start(), 1, 200, {})


@pytest.mark.long
def test_show_is_restored_where_the_file_is_gone_or_another(loaded, tmp_path):
    at, data = capture_from(ticked(loaded, 100), 100, {})
    bare = restore(replace(loaded, springs={}), data)
    assert view_of(ticked(loaded, at + 50, at + 1, bare)).spring.shape == (0, 0, 4)
    (tmp_path / "anna.glb").write_bytes(detailed_glb(**STYLES["Mixamo"] | {"strands": 3}))
    other = restore(replace(loaded, springs=character_springs(loaded.patch, loaded.path)), data)
    view = view_of(ticked(loaded, at + 50, at + 1, other))
    assert view.spring.shape[1] >= 3 * HAIR_BONES
    assert np.isfinite(view.spring).all()


@pytest.mark.long
def test_springs_begin_at_rest_after_a_stall_of_ten_seconds(loaded):
    show = ticked(loaded, 200)
    later = 200 + 640
    show.tick(later * TICK)
    assert angles(springs_in(view_of(show))).max() < 0.25  # gravity of one tick, not the motion of ten seconds
    for tick in range(later + 1, later + 100):
        show.tick(tick * TICK)
        assert angles(springs_in(view_of(show))).max() < 2.0


@pytest.mark.long
def test_picture_between_ticks_is_between_their_springs(loaded):
    show = ticked(loaded, 250)
    first, middle, last = (view_of(show, share * TICK).spring for share in (0.0, 0.5, 1.0))
    whole = np.abs(first - last).max()
    assert 1e-4 < whole < 0.2
    assert np.abs(0.5 * (first + last) - middle).max() < 0.1 * whole


@pytest.mark.long
def test_nearest_dancers_swing_if_there_are_too_many_springs(loaded, monkeypatch):
    show = loaded.start()
    size = show.springs.bone_count
    monkeypatch.setattr(module, "MAX_BONES", 2 * size)
    ticked(loaded, CHOICE_TICKS + FADE_TICKS + 20, 1, show)
    view = view_of(show)
    swinging = angles(springs_in(view)[:5]).max(axis=1) > 1e-3
    assert swinging.sum() == 2
    assert show.springs.resting == 3
    assert (show.springs._dancer >= 0).sum() == 2
    (note,) = show.springs.cast.notes()
    assert f"of 5 dancers have {5 * size} bones" in note
    eye = show.desk.parameters.picture[module.EYE]
    away = np.hypot(*(show.dancers.drawn_hips[:5] - eye[::2]).T)
    assert away[swinging].max() < away[~swinging].min() + 1.0


@pytest.mark.long
def test_show_goes_on_while_springs_are_out_of_service(loaded):
    show = ticked(loaded, 50)
    show.breakers.trip("springs", "a test")
    still = view_of(ticked(loaded, 120, 51, show)).spring
    assert np.array_equal(still, view_of(ticked(loaded, 150, 121, show)).spring)
    show.breakers.reset("springs")
    assert not np.array_equal(still, view_of(ticked(loaded, 200, 151, show)).spring)
