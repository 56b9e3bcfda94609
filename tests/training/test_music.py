"""Composed training pieces: laws of every style, without sound."""

from random import Random

import numpy as np
import pytest

import training.music.styles  # noqa: F401 (registers the styles)
from training.music.build import _rest
from training.music.harmony import Key, voicing
from training.music.melody import rhythm
from training.music.pattern import parse, weave
from training.music.piece import COMMON, JIG, THREE, Feel, Metre, Piece
from training.music.registry import STYLES, compose
from training.music.styles.odd_metres import line, metre_of
from training.music.tempo import change, expressive, human, steady

FAMILIES = sorted({style.family for style in STYLES.values()})


@pytest.mark.parametrize("family", FAMILIES)
def test_pieces_of_every_style_keep_the_laws(family: str) -> None:
    for style in STYLES.values():
        if style.family == family:
            _check_piece(compose(Random(style.name), style.name, 10.0))


def _check_piece(piece: Piece) -> None:
    beats = piece.beats()
    times = np.array([time for time, _ in beats])
    assert (np.diff(times) > 0.15).all()
    assert np.diff(times).max() < 6.5 + sum(length for _, length in piece.clock.gaps)
    assert [place for _, place in beats] == [index % piece.metre.beats + 1 for index in range(len(beats))]
    assert times[-1] - times[0] > 10.0
    notes = piece.perform(Random(1))
    assert notes == sorted(notes)
    assert all(0 <= note.pitch < 128 and 0 < note.velocity < 128 and note.duration > 0 for note in notes)
    assert {note.channel for note in notes} <= {channel for channel, _ in piece.programs()}
    assert 40 <= piece.bpm <= 216


def test_one_seed_gives_one_piece() -> None:
    for name in sorted(STYLES)[::9]:
        first, second = (compose(Random(3), name, 2.0).perform(Random(4)) for _ in range(2))
        assert first == second
        assert first != compose(Random(5), name, 2.0).perform(Random(4))


def test_note_onsets_concentrate_on_the_beats() -> None:
    """Over many styles far more notes begin on annotated beats than an eighth of a beat beside them."""
    on = beside = 0
    for name in sorted(STYLES)[::5]:
        piece = compose(Random(7), name, 4.0)
        times = np.array([time for time, _ in piece.beats()])
        starts = np.array([note.time for note in piece.perform(Random(8))])
        period = np.median(np.diff(times))
        for shift, count in ((0.0, "on"), (0.13 * period, "beside")):
            near = np.abs(starts[:, None] - (times + shift)[None, :]).min(axis=1) < 0.03
            if count == "on":
                on += int(near.sum())
            else:
                beside += int(near.sum())
    assert on > 2.5 * beside


def test_styles_cover_wide_tempo_and_meter_ranges() -> None:
    plans = [STYLES[name].draw(Random(f"{name}{turn}")) for name in sorted(STYLES) for turn in range(4)]
    tempi = np.array([plan.bpm for plan in plans])
    assert 95 < np.median(tempi) < 125
    assert tempi.min() < 60
    assert tempi.max() > 180
    assert {plan.metre.name for plan in plans} >= {"2/4", "3/4", "4/4", "6/8", "12/8"}
    held = [style for style in STYLES.values() if style.held_out]
    assert 5 <= len(held) <= len(STYLES) / 5


def test_odd_metres_count_every_beat_of_their_groups() -> None:
    assert metre_of((2, 2, 3)) == Metre(7, 2, (2, 4))
    assert line((2, 2, 3), "X.", "x.", "o.") == "X...x...o....."
    counted = {
        compose(Random(seed), style.name, 4.0).metre.beats
        for style in STYLES.values()
        for seed in range(12)
        if style.family == "odd"
    }
    assert counted >= {5, 7, 9, 11}


def test_rests_last_whole_bars_or_a_few_beats() -> None:
    piece = compose(Random(2), "rock", 4.0)
    rests = [_rest(Random(seed), piece) * 60 / piece.bpm for seed in range(200)]
    assert 0.2 < min(rests) < 2.0 < np.median(rests) < 7.0
    assert 8.0 < max(rests) < 18.0


def test_patterns_are_parsed_and_weighted_by_meter() -> None:
    assert parse("X...o.-.", 4) == [(0.0, 1.0), (2.0, 0.62), (3.0, 0.36)]
    assert parse("X..x..", 2) == [(0.0, 1.0), (1.0, 0.82)]
    hits = [at for seed in range(400) for at, _ in weave(Random(seed), COMMON, 0.4)]
    counts = {place: sum(abs(at - place) < 1e-6 for at in hits) for place in (0.0, 1.0, 0.5, 0.25)}
    assert counts[0.0] > counts[1.0] > counts[0.5] > counts[0.25]


def test_meter_strengths_and_names_are_correct() -> None:
    assert [COMMON.strength(beat) for beat in (0, 1, 2, 3, 0.5, 0.25)] == [4, 2, 3, 2, 1, 0]
    assert [JIG.strength(place) for place in (0, 1 / 3, 1, 1.5)] == [4, 1, 2, 0]
    assert (JIG.name, THREE.name, Metre(3, 3).name) == ("6/8", "3/4", "9/8")


@pytest.mark.parametrize("metre", [COMMON, THREE, JIG, Metre(4, 3)])
def test_rhythms_stay_in_their_measure(metre: Metre) -> None:
    for seed in range(200):
        line = rhythm(Random(seed), metre, seed / 200)
        assert all(0 <= at < metre.beats and at + length <= metre.beats + 1 for at, length in line)


def test_chords_match_their_names() -> None:
    key = Key(0, "major")
    assert key.chord("I").classes == (0, 4, 7)
    assert key.chord("ii7").classes == (2, 5, 9, 0)
    assert key.chord("bVII").classes == (10, 2, 5)
    assert (key.chord("V/vii").root, key.chord("V/vii").bass) == (7, 11)
    assert {pitch % 12 for pitch in voicing(key.chord("IV"), 60)} == {5, 9, 0}
    assert all(54 <= pitch <= 66 for pitch in voicing(key.chord("IV"), 60))


def test_tempo_clocks_match_their_parameters() -> None:
    assert steady(8, 120).seconds([0, 1, 2.5]).tolist() == [0, 0.5, 1.25]
    tempo = 60 / np.diff(human(Random(1), 4000, 100, 0.02).seconds(range(4000)))
    assert 97 < tempo.mean() < 103
    assert 1 < tempo.std() < 4
    assert (np.diff(expressive(Random(1), 32, 4, 60, 0.2).seconds(range(128))) > 0.5).all()
    clock = steady(16, 120)
    change(Random(1), clock, 8, 0.5)
    clock.gaps.append((8.0, 3.0))
    assert clock.seconds([7, 8, 9]).tolist() == [3.5, 7.0, 8.0]
    assert clock.silences() == [(4.0, 7.0)]
    ramp = steady(16, 120)
    change(Random(1), ramp, 4, 2.0, 8)
    periods = np.diff(ramp.seconds(range(16)))
    assert (np.diff(periods[4:12]) < 0).all()
    assert periods[-1] == pytest.approx(0.25)


@pytest.mark.long
def test_swing_moves_offbeats_and_keeps_beats() -> None:
    feel = Feel(swing=2 / 3)
    assert [feel.warp(beat) for beat in (0, 0.5, 1, 1.5)] == pytest.approx([0, 2 / 3, 1, 5 / 3])
    fine = Feel(swing_fine=0.6)
    assert [fine.warp(beat) for beat in (0.25, 0.5, 0.75)] == pytest.approx([0.3, 0.5, 0.8])
