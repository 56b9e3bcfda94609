"""Tests of the forms of a recorded step for other tempi: limits, exact motion, repetition, streams."""

from dataclasses import replace

import numpy as np
import pytest

from live.library.recording_file import Recording, RecordingEntry
from live.library.recordings import cut_stream
from live.motion.clip import Clip, read_clip
from live.motion.editing.tempo_forms import (
    TEMPO_LIMITS,
    NoTempoForm,
    all_forms,
    danced_twice,
    double_time,
    half_time,
    joined_stream,
    recorded_name,
    tempo_forms,
)
from live.motion.forward_kinematics import forward_kinematics
from live.motion.mirror import mirror_step
from live.motion.skeleton import SKELETON
from live.motion.step_clip import StepClip
from tests.fixtures.made_steps import made_clip
from tests.places import ROOT


def recorded(step: str = "sway", *, bpm: float = 100.0, **made: object) -> StepClip:
    return replace(made_clip(step, **made), recorded=True, bpm=bpm)  # type: ignore[arg-type]


def danced_ratios(bpm: float, show: float) -> list[float]:
    """How fast each form that a show gets is danced, as a share of its recorded speed."""
    step = recorded(bpm=bpm, measures=2)
    seconds = 2 * 4 * 60.0 / bpm  # of the recorded step
    forms = tempo_forms([step], (show, show)).clips
    return [seconds / (form.measures * 4 * 60.0 / show) for form in forms]


@pytest.mark.parametrize("show", np.geomspace(35.0, 280.0, 40).tolist())
def test_every_tempo_within_two_octaves_is_danced_within_limits(show: float) -> None:
    """Whatever is danced lies within 0.7 and 1.4 of its tempo."""
    (ratio,) = danced_ratios(100.0, show)
    assert TEMPO_LIMITS[0] - 1e-9 <= ratio <= TEMPO_LIMITS[1] + 1e-9


@pytest.mark.parametrize(("bpm", "show"), [(57.0, 161.0), (57.0, 19.0), (163.0, 56.0)])
def test_tempo_beyond_two_octaves_is_refused_with_reason(bpm: float, show: float) -> None:
    found = tempo_forms([recorded("salsa", bpm=bpm), recorded("walk", bpm=show)], (show, show))
    assert {clip.step for clip in found.clips} == {"walk"}
    words = found.refused["salsa"]
    assert f"recorded at {bpm:g} bpm" in words
    assert f"the show is at {show:g} bpm" in words
    assert f"play it at {0.35 * bpm:.4g} to {2.8 * bpm:.4g} bpm" in words
    assert found.notes == (f"left out: {words}",)


def test_sketched_steps_fit_any_tempo() -> None:
    step = made_clip("sway")
    found = tempo_forms([step], (300.0, 300.0))
    assert found.clips == [step]
    assert found.notes == ()


def test_music_with_two_tempi_has_both_forms() -> None:
    found = tempo_forms([recorded(bpm=100.0)], (90.0, 180.0))
    assert [clip.measures for clip in found.clips] == [1, 2]
    assert "is danced at half time where the show is at 90 to 180 bpm" in found.notes[0]


def test_half_time_is_the_same_motion_in_twice_as_many_measures() -> None:
    step = recorded(measures=2, way=(0.0, 0.8))
    half = half_time(step)
    assert (half.measures, half.beats, half.bpm) == (4, 16, 200.0)
    assert half.clip.root_position is step.clip.root_position
    assert (
        half.first + half.measures * half.samples_per_measure == step.first + step.measures * step.samples_per_measure
    )
    assert half.direction == "short forward"  # 0.4 m in a measure


def test_double_time_of_even_measures_is_the_same_motion_in_half_as_many() -> None:
    step = recorded(measures=4)
    double = double_time(step)
    assert (double.measures, double.bpm, double.samples_per_measure) == (2, 50.0, 2 * step.samples_per_measure)
    assert double.clip.rotation is step.clip.rotation


def test_step_danced_twice_goes_on_from_where_it_ended() -> None:
    """A step that goes 0.5 m and turns by a right angle: the second time it goes the same way, seen from the dancer."""
    step = recorded(way=(0.0, 0.5), turn=np.pi / 2)
    twice = danced_twice(step)
    ends = twice.first + np.arange(3) * step.samples_per_measure
    root, rotation, _ = read_clip(twice.clip, ends)
    np.testing.assert_allclose(root[:, (0, 2)], [[0.0, 0.0], [0.0, 0.5], [0.5, 0.5]], atol=1e-5)
    heading = 2.0 * np.arctan2(rotation[:, 0, 2], rotation[:, 0, 0])
    np.testing.assert_allclose(heading, [0.0, np.pi / 2, np.pi], atol=1e-5)
    jumps = np.linalg.norm(
        np.diff(forward_kinematics(twice.clip.root_position, twice.clip.rotation)[0], axis=0), axis=-1
    )
    own = np.linalg.norm(np.diff(forward_kinematics(step.clip.root_position, step.clip.rotation)[0], axis=0), axis=-1)
    assert jumps.max() < 1.5 * own.max()
    assert (double_time(step).measures, double_time(step).bpm) == (1, 50.0)


def test_weight_transfer_repeats_on_other_side() -> None:
    step = recorded(way=(0.3, 0.5))
    step = replace(step, weight_transfer=True, leading_foot="left")
    root, _, _ = read_clip(danced_twice(step).clip, step.first + np.arange(3) * step.samples_per_measure)
    np.testing.assert_allclose(root[:, (0, 2)], [[0.0, 0.0], [0.3, 0.5], [0.0, 1.0]], atol=1e-5)
    assert not danced_twice(step).weight_transfer


def crouching() -> StepClip:
    """A step that begins bent over and ends upright."""
    step = recorded("rise")
    rotation = step.clip.rotation.copy()
    angle = np.linspace(4.0, 0.0, len(rotation))
    rotation[:, SKELETON.index("spine"), 0] = np.cos(angle / 2)
    rotation[:, SKELETON.index("spine"), 1] = np.sin(angle / 2)
    return replace(step, clip=replace(step.clip, rotation=rotation))


def test_step_that_does_not_lead_to_its_beginning_is_not_repeated() -> None:
    with pytest.raises(NoTempoForm, match=r"its end is \d+ cm from its beginning"):
        double_time(crouching())
    named = replace(recorded(), begin_pose="low", end_pose="high")
    with pytest.raises(NoTempoForm, match="it ends in 'high' and begins in 'low'"):
        double_time(named)
    found = tempo_forms([crouching(), recorded("walk", bpm=50.0)], (50.0, 50.0))
    assert "play it at 70 to 280 bpm; at double time it cannot be danced, because its end is" in found.refused["rise"]


def stream(measures: int) -> tuple[Clip, list[StepClip]]:
    """A whole recording of an odd number of samples a measure, and its measures as `live/library/recordings.py` cuts
    them."""
    whole = recorded(measures=measures, way=(0.2, 0.4), turn=0.7).clip
    rotation, bend = whole.rotation.copy(), 0.3 * np.sin(0.037 * np.arange(whole.sample_count))
    rotation[:, SKELETON.index("spine"), 0] = np.cos(bend)
    rotation[:, SKELETON.index("spine"), 1] = np.sin(bend)
    whole = replace(whole, rotation=rotation)
    fields = {"file": "a.bvh", "name": "a", "bpm": 117.3, "first_beat_s": 2.1, "unstructured": True, "mirror": True}
    entry = RecordingEntry(Recording.model_validate(fields), ROOT / "a.toml", {}, ())
    return whole, cut_stream(entry, whole)


def test_stream_at_double_time_is_the_recording_without_a_seam() -> None:
    whole, cut = stream(6)
    pairs = [double_time(pair) for pair in joined_stream(cut[:4])]
    assert [pair.measures for pair in pairs] == [1, 1]
    for number, pair in enumerate(pairs):
        places = pair.first + np.linspace(-0.4, 1.0, 50) * pair.samples_per_measure
        hips = forward_kinematics(*read_clip(pair.clip, places)[:2])[0]
        start = (2.1 + 2 * number * 4 * 60.0 / 117.3) * whole.sample_rate
        truth = forward_kinematics(*read_clip(whole, start + (places - pair.first))[:2])[0]
        apart = np.linalg.norm(hips[:, None, 5] - hips[None, :, 5], axis=-1)  # independent of placement and heading
        np.testing.assert_allclose(apart, np.linalg.norm(truth[:, None, 5] - truth[None, :, 5], axis=-1), atol=1e-4)


def test_measures_that_do_not_follow_each_other_are_not_joined() -> None:
    _, cut = stream(6)
    assert [pair.measures for pair in joined_stream([cut[0], cut[2], cut[3]])] == [1, 2]


def test_forms_have_names_of_their_own_and_know_their_recording() -> None:
    step = recorded()
    forms = list(all_forms([step, mirror_step(step)]))
    names = [form.clip.name for form in forms]
    assert len(set(names)) == 6
    assert {recorded_name(name) for name in names} == {step.clip.name, mirror_step(step).clip.name}
