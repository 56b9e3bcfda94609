"""Measures danced by other bodies are recognised as steps of a library; other motion is not."""

import numpy as np
import pytest

from bench._seen_bodies import danced_by_another
from live.library.step_folder import load_folder
from live.motion.recognition.step_recognition import MIN_MOTION, UNKNOWN, StepTemplates, is_seen, motion_of
from live.show.patch.patch_search_path import PATCHES
from tests.fixtures.mostly_long import mostly_long


@pytest.fixture(scope="module")
def clips():
    return [clip for clip in load_folder(PATCHES / "steps") if not clip.unjoined]


@pytest.fixture(scope="module")
def templates(clips):
    names = sorted({clip.step for clip in clips})
    return names, StepTemplates.of([(names.index(clip.step), clip) for clip in clips], 4)


def some(clips):
    """One clip of each step."""
    found = {}
    for clip in clips:
        found.setdefault(clip.step, clip)
    return found.values()


@mostly_long("count", [4, 2], quick=[1])
def test_steps_are_recognised_in_other_bodies_at_other_tempos(clips, templates, count):
    names, known = templates
    chance = np.random.default_rng(11)
    found = []
    for clip in some(clips):
        for measure in range(clip.measures):
            seen = danced_by_another(clip, measure, float(chance.uniform(80, 140)), chance)
            result = known.recognise(seen.hips, seen.rotation, seen.beats, 0.0, count)
            found.append(result.step >= 0 and names[result.step] == clip.step and result.measure == measure)
            assert result.step < 0 or names[result.step] == clip.step
    assert np.mean(found) >= 0.85


def test_mirror_image_is_noted(clips, templates):
    names, known = templates
    (clip,) = [clip for clip in some(clips) if clip.step == "kick"]
    for mirror in (False, True):
        seen = danced_by_another(clip, 0, 120.0, np.random.default_rng(3), mirror=mirror, jitter=0.0)
        result = known.recognise(seen.hips, seen.rotation, seen.beats, 0.0)
        assert names[result.step] == "kick"
        assert result.mirrored == (mirror != clip.mirrored)


def test_step_that_is_not_in_the_library_is_unknown(clips):
    others = [(0, clip) for clip in clips if clip.step == "groove"]
    known = StepTemplates.of(others, 4)
    for clip in some(clips):
        seen = danced_by_another(clip, 0, 120.0, np.random.default_rng(4), jitter=0.0)
        assert (known.recognise(seen.hips, seen.rotation, seen.beats, 0.0).step == 0) == (clip.step == "groove"), (
            clip.step
        )


def test_still_body_is_unknown_and_does_not_move(templates):
    _, known = templates
    rotation = np.zeros((60, 22, 4))
    rotation[..., 0] = 1.0
    hips, beats = np.tile((0.0, 0.93, 0.0), (60, 1)), np.linspace(-0.2, 4.2, 60)
    assert known.recognise(hips, rotation, beats, 0.0).step == -1
    assert motion_of(hips, rotation, beats, 0.0, 4) < MIN_MOTION


def test_gaps_and_missing_poses_are_unknown(clips, templates):
    _, known = templates
    seen = danced_by_another(clips[0], 0, 120.0, np.random.default_rng(5))
    kept = (seen.beats < 1.0) | (seen.beats > 2.2)
    assert not is_seen(seen.beats[kept], 0.0, 4)
    assert known.recognise(seen.hips[kept], seen.rotation[kept], seen.beats[kept], 0.0) is UNKNOWN
    assert known.recognise(seen.hips[:1], seen.rotation[:1], seen.beats[:1], 0.0) is UNKNOWN
    empty = StepTemplates.of([], 4)
    assert empty.recognise(seen.hips, seen.rotation, seen.beats, 0.0) is UNKNOWN


def test_joined_templates_are_those_made_at_once(clips, templates):
    names, known = templates
    ordered = [(names.index(clip.step), clip) for clip in clips if not clip.mirrored]
    joined = StepTemplates.of(ordered[:5], 4).joined(StepTemplates.of(ordered[5:], 4))
    assert np.array_equal(joined.step, known.step)
    assert np.array_equal(joined.clouds[3].floor, known.clouds[3].floor)
