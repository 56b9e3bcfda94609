"""A short rendered item: attacks lie on the annotated beats, and the same seed gives the same bytes."""

from pathlib import Path
from random import Random

import numpy as np
import pytest

from tests.fixtures.mostly_long import mostly_long
from training.dataset import _fewer, choose, write
from training.music.piece import Sounding
from training.music.registry import compose
from training.rendering import level, medium, noise, room
from training.rendering.damage import Take, spoil
from training.rendering.synth import RATE, available, fonts, synthesise
from training.report import measure

NOTES = [Sounding(0.5 * beat + 0.25, 0.1, 9, 75, 110) for beat in range(5)]


def _needs_fluidsynth() -> None:
    reason = available()
    if reason is not None or "TimGM6mb.sf2" not in fonts():
        pytest.skip(reason or "TimGM6mb is not installed (apt: timgm6mb-soundfont)")


def test_attacks_lie_on_their_note_times() -> None:
    _needs_fluidsynth()
    sound = synthesise(NOTES, [(9, 0)], fonts()["TimGM6mb.sf2"], 3.0)
    again = synthesise(NOTES, [(9, 0)], fonts()["TimGM6mb.sf2"], 3.0)
    assert sound.tobytes() == again.tobytes()
    for note in NOTES:
        start = int((note.time - 0.1) * RATE)
        window = np.abs(sound[start : start + RATE // 5])
        attack = np.argmax(window > 0.3 * window.max()) / RATE - 0.1
        assert abs(attack) < 0.003


def test_item_is_written_completely_and_reproducibly(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    _needs_fluidsynth()
    monkeypatch.setattr("training.dataset.FONTS", {"TimGM6mb.sf2": 1.0})
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        write(tmp_path / folder, 3, "train", 1, 3.0)
    names = sorted(path.name for path in (tmp_path / "a").iterdir())
    assert names == ["00003.beats", "00003.json", "00003.wav"]
    for name in names:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
    facts = measure(tmp_path / "a" / "00003")
    assert facts["seconds"] == pytest.approx(3.0, abs=0.5)


@pytest.mark.long
def test_some_bands_lose_their_drums_or_all_but_these() -> None:
    told: dict[str, int] = {}
    for seed in range(80):
        piece = compose(Random(seed), "rock", 10.0)
        notes = piece.perform(Random(seed))
        kept, said = _fewer(Random(seed), piece, notes)
        told[said] = told.get(said, 0) + 1
        drums = {note.channel == 9 for note in kept}
        assert drums <= {"": {True, False}, "without drums": {False}, "drums alone": {True}}[said]
        assert said or kept == notes
    assert told[""] > told["without drums"] > told["drums alone"] > 0
    alone = compose(Random(1), "drummer: rock", 10.0)
    assert all(_fewer(Random(seed), alone, notes)[1] == "" for seed in range(20))


def test_families_restrict_the_draw() -> None:
    styles = {choose(Random(seed), "held-out", ("slow", "odd")) for seed in range(40)}
    assert {style.family for style in styles} == {"slow", "odd"}
    assert all(style.held_out for style in styles)


def _clicks() -> np.ndarray:
    sound = np.zeros(10 * RATE, np.float32)
    for beat in range(19):
        sound[int((0.25 + 0.5 * beat) * RATE) :][:400] = np.linspace(1, 0, 400)
    return sound


@mostly_long("seed", range(8), quick=[0, 4])
def test_damage_keeps_sound_and_beats_valid(seed: int) -> None:
    take = spoil(Random(seed), Take(_clicks(), [(0.25 + 0.5 * beat, 1 + beat % 4) for beat in range(19)], []), 1.0)
    assert np.isfinite(take.sound).all()
    assert np.abs(take.sound).max() <= 1.0
    assert len(take.done) > 0
    assert (np.diff([time for time, _ in take.beats]) > 0.4).all()
    assert all(start < end for start, end in take.ignore)


def test_warp_moves_sound_and_times_equally() -> None:
    rng = np.random.default_rng(1)
    warp = medium.fader(rng, 10.0)
    sound = warp.play(_clicks())
    times = warp.at(np.array([0.25 + 0.5 * beat for beat in range(18)]))
    for time in times:
        window = sound[int((time - 0.05) * RATE) : int((time + 0.05) * RATE)]
        assert abs(np.argmax(window > 0.5) / RATE - 0.05) < 0.002


def test_room_decay_and_noise_level_match_parameters() -> None:
    rng = np.random.default_rng(2)
    click = np.zeros(3 * RATE, np.float32)
    click[0] = 1.0
    heard = room.room(rng, click, 1.0, 0.0)
    assert heard[0] == pytest.approx(1.0, rel=1e-3)
    energy = [float(np.sum(heard[int(at * RATE) : int((at + 0.1) * RATE)] ** 2)) for at in (0.1, 0.6)]
    assert 10 * np.log10(energy[0] / energy[1]) == pytest.approx(30, abs=4)
    tone = np.sin(np.arange(RATE) * 0.05).astype(np.float32)
    added = noise.add(tone, noise.pink(rng, RATE), 10.0) - tone
    assert 10 * np.log10(np.mean(tone**2) / np.mean(added**2)) == pytest.approx(10, abs=0.1)
    assert np.abs(level.clip(rng, tone)).max() <= 1.0
