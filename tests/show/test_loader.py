"""Show loader: meters, recordings without transitions, and recording names."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from live.base.errors import PersonError
from live.motion.mirror import mirror_step
from live.motion.step_clip import StepClip
from live.show.loader import LoadedShow, load_from_patch, load_show
from live.show.patch.patch_reader import parse_patch
from live.show.patch.patch_search_path import DEFAULT_PATCH
from live.show.selection import show_clips
from tests.fixtures.made_steps import made_clip, made_steps
from tests.show.made_show import PATCH

HERE = Path("show.toml")


def load_with_clips(monkeypatch, clips, patch=PATCH, recordings=Path("recordings")):
    monkeypatch.setattr(show_clips, "load_folder", lambda folder: clips)
    return load_from_patch(parse_patch(patch, "show.toml"), HERE, recordings=recordings)


def test_recordings_replace_the_steps_of_every_group(monkeypatch):
    show = load_with_clips(monkeypatch, made_steps())
    assert all(group.choose == "random" and group.travel_step is None for group in show.patch.group)
    show.start()


def test_recordings_of_another_meter_are_left_out(monkeypatch):
    show = load_with_clips(monkeypatch, [*made_steps(), made_clip("waltz", beats=3)])
    assert show.patch.clock.beats_per_measure == 4
    assert "waltz" not in show.graph.library.steps
    show.start()


def test_meter_is_that_of_most_recordings(monkeypatch):
    show = load_with_clips(monkeypatch, [made_clip("sway"), made_clip("waltz", beats=3), made_clip("boston", beats=3)])
    assert show.patch.clock.beats_per_measure == 3


def test_recording_without_transitions_is_noted_and_left_out(monkeypatch):
    flying = made_clip("flying")
    root = flying.clip.root_position + np.array([0.0, 1.0, 0.0], np.float32)
    flying = replace(flying, clip=replace(flying.clip, root_position=root))
    show = load_with_clips(monkeypatch, [*made_steps(), flying])
    assert any("flying" in note for note in show.graph.missing)
    assert not any("flying" in entry for group in show.patch.group for entry in group.steps)
    show.start()


def test_recording_name_can_look_like_a_repeat(monkeypatch):
    show = load_with_clips(monkeypatch, [made_clip("take x2"), made_clip("take x3")])
    show.start()


def test_step_of_another_meter_is_refused_with_both_meters(monkeypatch):
    patch = PATCH.replace('"spin", "phrase"]', '"waltz"]')
    with pytest.raises(PersonError, match="step 'waltz' of group 'front' has 3 beats per measure, this show has 4"):
        load_with_clips(monkeypatch, [*made_steps(), made_clip("waltz", beats=3)], patch, recordings=None)


def test_error_without_matching_meter_names_found_meters(monkeypatch):
    patch = PATCH.replace("bpm = 120", "bpm = 120\nbeats_per_measure = 7")
    with pytest.raises(PersonError, match="no step has 7 beats per measure; the steps found have 4"):
        load_with_clips(monkeypatch, made_steps(), patch, recordings=None)


@pytest.mark.long
def test_metric_weights_come_from_the_patch(tmp_path):
    """Weights on hands alone and on feet alone give different edges; an unknown joint is refused by name."""
    text = DEFAULT_PATCH.read_text()

    def edges(weights):
        path = tmp_path / "show.toml"
        path.write_text(f"locomotion = {{weights = {{{weights}}}}}\n" + text)
        return load_show(path).graph.edge_count

    assert edges("leftHand = 50, rightHand = 50") != edges("leftFoot = 50, rightFoot = 50")
    with pytest.raises(PersonError, match="leftHoof"):
        edges("leftHoof = 1")


def two_takes() -> list[StepClip]:
    first, second = made_clip("sway"), made_clip("sway")
    second = replace(second, clip=replace(second.clip, name="sway, textured 1"))
    return [*made_steps(), first, second, mirror_step(first), mirror_step(second)]


def names_of(show: LoadedShow, step: str) -> set[str]:
    return {clip.clip.name for clip in show.graph.library.clips if clip.step == step}


def test_chosen_takes_are_danced_with_their_mirror_images(monkeypatch):
    clips = two_takes()
    first = clips[-4].clip.name
    assert len(names_of(load_with_clips(monkeypatch, clips), "sway")) == 4
    show = load_with_clips(monkeypatch, clips, 'takes = {Sway = ["sway, textured 1"]}\n' + PATCH)
    assert names_of(show, "sway") == {"sway, textured 1", "sway, textured 1 (mirrored)"}
    others = {clip.step for clip in clips} - {"sway"}
    assert others <= set(show.graph.library.steps)
    assert first not in names_of(show, "sway")


@pytest.mark.parametrize(
    ("takes", "words"),
    [
        ('{swim = ["swim"]}', "there is no step 'swim'; there are: "),
        ('{sway = ["sway, textured 2"]}', "the step 'sway' has no take 'sway, textured 2'; there are: "),
        ("{sway = []}", "takes.sway"),
    ],
)
def test_unknown_takes_are_refused(monkeypatch, takes, words):
    with pytest.raises(PersonError, match=words):
        load_with_clips(monkeypatch, two_takes(), f"takes = {takes}\n" + PATCH)
