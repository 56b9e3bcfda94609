"""Tests of live texturing: choice on the beat, continuity, determinism, snapshots and load over ticks."""

from pathlib import Path

import numpy as np
import pytest

from live.base.errors import PersonError
from live.base.motion_parameters import TEXTURE
from live.clock.ticks import TICK
from live.control.events import events
from live.motion.texture.live_bank import TextureBank, leg_positions, prefix_features, stack_features
from live.motion.texture.live_texture_kernels import DIMENSIONS, FEATURES, PER_BEAT, SLOTS, UPPER_COUNT, write_prefix
from live.show.assembly import assemble
from live.show.dancers.live_texture import BLEND, CHOICE_TICKS, PREFIX
from live.show.loader import LoadedShow, load_texture_bank
from live.show.patch.patch_reader import parse_patch
from live.show.show import Show
from live.show.state.snapshot import Snapshotter, restore
from tests.motion.texture.made_dance import BEAT, RATE, at_beats, dance
from tests.show.made_show import GRAPH, PATCH

BANK = TextureBank.of([dance(20.0, seed) for seed in (1, 2, 3)])
FREE = TextureBank.of([at_beats(20.0, seed, 0.3) for seed in (1, 2, 3)])
"""Recordings whose upper bodies are unlike those of `GRAPH`, also where legs hardly move, as there."""
MOTION = "[motion]\ntexture = 1.0\nhead = 0.0\n"


def make_textured_show(texture: float = 1.0, seed: int = 3, bank: TextureBank = BANK) -> Show:
    patch = parse_patch(PATCH + MOTION.replace("1.0", str(texture)), "test.toml")
    return assemble(patch, GRAPH, seed=seed, bank=bank)


def run(show: Show, first: int, last: int, *, drawn: bool = False) -> np.ndarray:
    """Rotations of all joints at each tick from `first` to `last`, (ticks, A, J, 4); `drawn`: with extra renders."""
    view, out = show.view(), []
    for tick in range(first, last + 1):
        show.tick(tick * TICK)
        if drawn:
            show.fill(show.view(), tick * TICK + 0.7 * TICK)
            show.fill(show.view(), tick * TICK + 0.2 * TICK)
        show.fill(view, tick * TICK)
        out.append(view.joint_rotation.copy())
    return np.array(out)


def max_angular_speed(rotation: np.ndarray) -> float:
    """The largest angular speed of any joint between two ticks [rad/s]."""
    dot = np.abs(np.sum(rotation[1:] * rotation[:-1], axis=-1))
    return float(2.0 * np.arccos(np.minimum(dot, 1.0)).max() / TICK)


def test_leg_history_features_match_bank_features() -> None:
    step = dance(8.0, 4)
    at = np.arange(0.0, 8.0 * RATE, BEAT / PER_BEAT)
    rotation = step.clip.rotation[np.minimum(np.round(at).astype(int), step.clip.sample_count - 1)]
    tracks = leg_positions(rotation)
    begin = np.array([PER_BEAT * 5], np.int32)
    wanted = prefix_features(tracks, begin, np.zeros(1, np.int32))[:, 0]
    kept = np.zeros((16, FEATURES), np.float32)
    for moment in range(8 * 5 - 4, 8 * 5 + 3):
        kept[moment % 16] = tracks[2 * moment]
    own = np.zeros(DIMENSIONS, np.float32)
    write_prefix(own, kept, 5)
    assert np.abs(own - wanted).max() < 1e-5
    assert stack_features(np.zeros((SLOTS, 3, FEATURES))).shape == (DIMENSIONS, 3)


@pytest.mark.long
def test_dancers_are_textured_within_two_beats_and_choose_once_per_beat() -> None:
    show = make_textured_show(bank=FREE)
    texturing = show.dancers.texture
    chosen, lines = [], []
    for tick in range(1, 64 * 4):
        show.tick(tick * TICK)
        if tick == 64:  # two beats at 120 bpm
            assert np.all(texturing.fragment >= 0)
        chosen.append(texturing.chosen_beat.copy())
        lines.append(texturing.beats_at(show.dancers.phases(show.span.fraction(show.timeline.beat_at(tick * TICK)))))
    after, danced = np.array(chosen)[64:], np.array(lines)[64:]
    assert np.all(np.isin(np.diff(after, axis=0), (0, 1)))
    assert np.all(danced - after < 2.0)  # committed within one beat of the beat it is for
    assert np.all(danced >= after + PREFIX - 1e-6)  # and never before what it rests on was seen
    assert texturing.level.min() > 0.99
    position, rotation = show.dancers.pose(0.3, show.time)
    plain = make_textured_show(0.0, bank=FREE)
    for tick in range(1, 64 * 4):
        plain.tick(tick * TICK)
    bare_position, bare_rotation = plain.dancers.pose(0.3, plain.time)
    legs = [0, *range(UPPER_COUNT + 1, rotation.shape[1])]
    assert np.array_equal(rotation[:, legs], bare_rotation[:, legs])
    assert np.abs(rotation[:, 1:14] - bare_rotation[:, 1:14]).max() > 0.2
    bones = np.linalg.norm(position[:, 9] - position[:, 8], axis=-1)
    assert np.allclose(bones, np.linalg.norm(bare_position[:, 9] - bare_position[:, 8], axis=-1), atol=1e-5)


@pytest.mark.long
def test_fader_jumps_cause_no_pop() -> None:
    show = make_textured_show(0.0)
    quiet = max_angular_speed(run(show, 1, 64 * 2))
    moved = []
    for part, value in enumerate((1.0, 0.5, 0.0, 0.7, 1.0), start=2):
        show.apply(
            events.SetParameter(time=show.time, source="osc", address=TEXTURE.address, value=(value,), group="*")
        )
        moved.append(run(show, 64 * part + 1, 64 * part + 64))
    data = 2.0 * np.arccos(np.minimum(np.abs(np.sum(BANK.upper[1:] * BANK.upper[:-1], axis=-1)), 1.0))
    inside = np.ones(len(data), np.bool_)
    inside[np.unique(BANK.clip_last)[:-1]] = False  # from one recording to the next
    of_data = float(data[inside].max()) * PER_BEAT * 2.0  # 120 bpm
    swing = 1.875 * np.pi / (BLEND * 0.5)  # half a turn within a blend, at its fastest
    assert max_angular_speed(np.concatenate(moved)) < quiet + of_data + swing < np.pi / TICK / 4.0


def test_dancers_with_same_step_use_several_fragments_deterministically() -> None:
    one, other = make_textured_show(), make_textured_show()
    assert np.array_equal(run(one, 1, 200), run(other, 1, 200, drawn=True))
    assert one.state_hash() == other.state_hash()
    assert len(set(one.dancers.texture.fragment.tolist())) > 1
    another = make_textured_show(seed=4)
    run(another, 1, 200)
    assert not np.array_equal(another.dancers.texture.fragment, one.dancers.texture.fragment)


def test_snapshot_continues_bit_identically_without_recordings() -> None:
    show = make_textured_show()
    run(show, 1, 120)
    source, tick = Snapshotter(show), 120
    while (taken := source.capture(tick)) is None:
        tick += 1
        show.tick(tick * TICK)
    patch = parse_patch(PATCH + MOTION, "test.toml")
    again = restore(LoadedShow(Path("test.toml"), patch, GRAPH, bank=BANK), taken.seal())
    assert again.dancers.texture.bank is BANK
    assert np.array_equal(run(again, tick + 1, tick + 80), run(show, tick + 1, tick + 80))
    assert again.state_hash() == show.state_hash()


def test_untextured_dancers_are_unchanged() -> None:
    patch = parse_patch(PATCH + MOTION.replace("1.0", "0.0"), "test.toml")
    with_bank, without = assemble(patch, GRAPH, bank=BANK), assemble(patch, GRAPH)
    assert np.array_equal(run(with_bank, 1, 40), run(without, 1, 40))
    assert not with_bank.dancers.texture.active


def test_show_without_recordings_refuses_texture() -> None:
    show = assemble(parse_patch(PATCH, "test.toml"), GRAPH)
    asked = events.SetParameter(time=0.0, source="osc", address=TEXTURE.address, value=(0.5,), group="*")
    assert not show.apply(asked)
    assert not show.variation.any(TEXTURE)
    assert show.refusals.count == 1
    assert show.apply(events.SetParameter(time=0.0, source="osc", address=TEXTURE.address, value=(0.0,), group="*"))


def test_choices_are_spread_over_ticks() -> None:
    show, most = make_textured_show(), 0
    before = show.dancers.texture.chosen_beat.copy()
    for tick in range(1, 160):
        show.tick(tick * TICK)
        most = max(most, int((show.dancers.texture.chosen_beat != before).sum()))
        before = show.dancers.texture.chosen_beat.copy()
    assert 0 < most <= -(-len(before) // CHOICE_TICKS)


def test_patch_with_missing_recordings_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "show.toml"
    asked = parse_patch(PATCH + MOTION, "test.toml")
    with pytest.raises(PersonError, match=r"motion\.texture is 1"):
        load_texture_bank(asked, path)
    for written, words in (('["nowhere"]', "no file and no folder 'nowhere'"), ('["empty"]', "no motion files in")):
        (tmp_path / "empty").mkdir(exist_ok=True)
        patch = parse_patch(PATCH + f"[texture]\nrecordings = {written}\n", "test.toml")
        with pytest.raises(PersonError, match=words):
            load_texture_bank(patch, path)
    with pytest.raises(ValueError, match="four beats"):
        TextureBank.of([])
