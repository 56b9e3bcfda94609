"""Manual hints: tempo and its level, half and double tempo, the downbeat, the metre."""

import numpy as np
import pytest

from live.clock.bar_pointer.bar_pointer import BarPointer
from tests.clock.bar_pointer.made import RATE, errors, follow, groove
from tests.fixtures.mostly_long import mostly_long


@pytest.mark.long
def test_tapped_tempo_and_its_level_are_kept() -> None:
    """Every beat of the groove sounds; the operator taps only every second one."""
    activations = groove(150.0, 4, 20.0)
    pointer = BarPointer()
    follow(pointer, activations, 0, int(5.0 * RATE))
    assert pointer.tempo == pytest.approx(150.0, rel=0.03)
    pointer.set_tempo(75.0)
    follow(pointer, activations, int(5.0 * RATE), int(5.1 * RATE))
    assert pointer.tempo == pytest.approx(75.0, rel=0.04)
    follow(pointer, activations, int(5.1 * RATE))
    assert pointer.tempo == pytest.approx(75.0, rel=0.03)


def test_inexact_tapped_tempo_is_corrected_by_music() -> None:
    activations = groove(96.0, 4, 12.0)
    pointer = BarPointer()
    follow(pointer, activations, 0, int(3.0 * RATE))
    pointer.set_tempo(99.5)
    follow(pointer, activations, int(3.0 * RATE))
    assert pointer.tempo == pytest.approx(96.0, rel=0.015)


@mostly_long("factor", [2.0, 0.5], quick=[0])
def test_tempo_scaling_takes_effect_at_once(factor: float) -> None:
    activations = groove(100.0, 4, 12.0)
    pointer = BarPointer()
    follow(pointer, activations, 0, int(8.0 * RATE))
    before = pointer.interval
    pointer.scale(factor)
    follow(pointer, activations, int(8.0 * RATE), int(8.0 * RATE) + 4)
    assert pointer.interval == pytest.approx(before / factor, rel=0.03)
    late = errors(follow(pointer, activations, int(8.0 * RATE) + 4), activations, 8.1)
    near = np.abs(late) < 0.04
    assert near.all() if factor == 0.5 else 0.3 < np.mean(near) < 0.7
    assert pointer.tempo == pytest.approx(100.0 * factor, rel=0.03)


def test_scaling_out_of_range_changes_nothing() -> None:
    activations = groove(200.0, 4, 6.0)
    pointer = BarPointer()
    follow(pointer, activations)
    before = pointer.interval
    pointer.scale(2.0)
    pointer.step(0.01, 0.003)
    assert pointer.interval == pytest.approx(before, rel=0.02)
    with pytest.raises(ValueError, match=r"2 or 0\.5"):
        pointer.scale(3.0)


@mostly_long("wanted", [0, 1, 2, 3], quick=[2])
def test_marked_downbeat_sets_the_measure(wanted: int) -> None:
    """Without downbeat activations, the marked beat begins the measures from then on."""
    activations = groove(116.0, 4, 16.0)
    activations.downbeat[:] = 0.25 * activations.beat
    pointer = BarPointer()
    pointer.set_metre(4)
    begin = int(8.0 * RATE)
    follow(pointer, activations, 0, begin)
    pressed = activations.truth[activations.truth < begin - 5][-4 + wanted]
    pointer.set_downbeat(begin - 1 - pressed + 1.5)  # pressed a little early
    followed = follow(pointer, activations, begin)
    number = np.argmin(np.abs(followed.time[:, None] - activations.truth[None]), axis=1)
    first = int(np.argmin(np.abs(activations.truth - pressed)))
    assert np.all(followed.beat == (number - first) % 4)


@mostly_long(
    ("wrong", "known_metre"),
    [
        (2, True),
        (1, False),
        *(pytest.param(*more, marks=pytest.mark.long) for more in ((1, True), (3, True), (2, False), (3, False))),
    ],
    quick=[],
)
def test_marked_downbeat_stays_against_all_evidence_and_the_music_is_the_runner_up(
    wrong: int, known_metre: bool
) -> None:
    """The operator presses a beat that is not the music's one. For two minutes measures begin there, and beside it the
    evidence says by how many beats the music's own line is later."""
    activations = groove(116.0, 4, 120.0)
    pointer = BarPointer()
    if known_metre:
        pointer.set_metre(4)
    begin = int(6.0 * RATE)
    follow(pointer, activations, 0, begin)
    pointer.set_downbeat(begin - 1 - activations.truth[8 + wrong])
    followed = follow(pointer, activations, begin)
    number = np.argmin(np.abs(followed.time[:, None] - activations.truth[None]), axis=1)
    assert np.all(followed.beat == (number - wrong) % 4)
    later, share = pointer.line_evidence.runner_up
    assert later == 4 - wrong
    assert share > 0.95


@mostly_long("late", [-0.24, -0.15, 0.15, 0.24], quick=[])
def test_a_press_beside_the_beat_takes_the_nearest_beat(late: float) -> None:
    activations = groove(116.0, 4, 60.0)
    pointer = BarPointer()
    begin = int(10.0 * RATE)
    follow(pointer, activations, 0, begin)
    period = 60.0 * RATE / 116.0
    pointer.set_downbeat(begin - 1 - (activations.truth[14] + late * period))
    followed = follow(pointer, activations, begin)
    off = np.abs(followed.time[:, None] - activations.truth[None]).min(axis=1)
    assert off.max() < 3.0  # frames
    number = np.argmin(np.abs(followed.time[:, None] - activations.truth[None]), axis=1)
    assert np.all(followed.beat == (number - 14) % 4)


@pytest.mark.long
def test_a_press_on_the_off_beat_moves_a_tracker_that_is_off_the_beat() -> None:
    """At first only off-beats sound, and the tracker is sure of them; the hand knows better, and stays right."""
    activations = groove(116.0, 4, 60.0)
    period = 60.0 * RATE / 116.0
    other = groove(116.0, 4, 60.0, first=7.3 + 0.5 * period)
    pointer, begin = BarPointer(), int(10.0 * RATE)
    beat = np.maximum(0.75 * activations.beat, other.beat)
    beat[:begin] = other.beat[:begin]
    for frame in range(beat.size):
        if frame == begin:
            assert np.abs(begin - 1 - pointer.since_beat - other.truth).min() < 3.0
            pointer.set_downbeat(begin - 1 - activations.truth[16])
        pointer.step(float(beat[frame]), 0.25 * float(beat[frame]))
    last = beat.size - 1 - pointer.since_beat
    assert np.abs(last - activations.truth).min() < 4.0


@pytest.mark.long
def test_other_music_after_a_pause_finds_its_own_line_and_metre() -> None:
    """A one is pressed in four four; after ten seconds of silence comes a waltz in another tempo."""
    pointer = BarPointer()
    first = groove(116.0, 4, 30.0)
    follow(pointer, first, 0, int(10.0 * RATE))
    pointer.set_downbeat(int(10.0 * RATE) - 1 - first.truth[16])
    follow(pointer, first, int(10.0 * RATE))
    for _ in range(round(10.0 * RATE)):
        pointer.step(0.005, 0.002, listening=False)
    pointer.resume(0.35)
    waltz = groove(158.0, 3, 40.0)
    followed = follow(pointer, waltz)
    late = followed.time > 25.0 * RATE
    assert set(followed.metre[late]) == {3}
    number = np.argmin(np.abs(followed.time[late][:, None] - waltz.truth[None]), axis=1)
    assert np.all(followed.beat[late] == number % 3)


@pytest.mark.long
def test_music_that_agrees_with_the_marked_downbeat_has_no_strong_runner_up() -> None:
    activations = groove(116.0, 4, 60.0)
    pointer = BarPointer()
    begin = int(6.0 * RATE)
    follow(pointer, activations, 0, begin)
    pointer.set_downbeat(begin - 1 - activations.truth[8])
    follow(pointer, activations, begin)
    assert pointer.line_evidence.measures > 20.0
    assert pointer.line_evidence.runner_up[1] < 0.05


@pytest.mark.long
def test_without_evidence_all_lines_are_equally_likely() -> None:
    activations = groove(116.0, 4, 40.0)
    activations.downbeat[:] = 0.25 * activations.beat
    pointer = BarPointer()
    pointer.set_metre(4)
    follow(pointer, activations)
    assert pointer.line_evidence.runner_up[1] == pytest.approx(0.25, abs=0.05)


@mostly_long("metre", [2, 3, 4, 5, 6, 7, 9], quick=[4])
def test_manual_metre_is_kept(metre: int) -> None:
    activations = groove(120.0, 4, 8.0)
    pointer = BarPointer()
    follow(pointer, activations, 0, 300)
    pointer.set_metre(metre)
    followed = follow(pointer, activations, 300)
    assert np.all(followed.metre == metre)
    pointer.set_metre(0)


@pytest.mark.long
def test_a_metre_that_cannot_be_counted_frees_it() -> None:
    activations = groove(120.0, 4, 16.0)
    pointer = BarPointer()
    pointer.set_metre(3)
    pointer.set_metre(11)
    assert set(follow(pointer, activations).metre[-8:].tolist()) == {4}


def test_invalid_tempo_is_refused() -> None:
    pointer = BarPointer()
    for bpm in (0.0, 500.0, float("nan")):
        with pytest.raises(ValueError, match="bpm"):
            pointer.set_tempo(bpm)


@pytest.mark.long
def test_clearing_manual_hints_releases_the_level() -> None:
    activations = groove(160.0, 4, 30.0)
    pointer = BarPointer()
    follow(pointer, activations, 0, 200)
    pointer.set_tempo(80.0)
    follow(pointer, activations, 200, 600)
    assert pointer.tempo == pytest.approx(80.0, rel=0.03)
    pointer.clear_manual()
    follow(pointer, activations, 600)
    assert pointer.tempo == pytest.approx(160.0, rel=0.03)
