"""Recorded steps keep near their tempo: what a show loads, what its dancers choose, what the operator is told."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from live.base.errors import PersonError
from live.clock.ticks import TICK
from live.control.events.events import SetTempo
from live.graph.motion_graph import build_graph
from live.graph.step_library import build_library
from live.motion.editing.tempo_forms import TEMPO_LIMITS, all_forms, tempo_forms
from live.show.assembly import assemble
from live.show.loader import load_from_patch
from live.show.patch.patch_reader import parse_patch
from live.show.selection import show_clips
from live.show.selection.choices import tempo_line
from live.show.selection.graph_update import clip_key, library_hash
from live.show.selection.show_clips import ShowTempo
from tests.fixtures.made_steps import made_clip, made_steps
from tests.show.made_show import PATCH

HERE = Path("show.toml")


def recorded(step, bpm, **made):
    """A made clip as if recorded at `bpm`: its samples are that much faster or slower."""
    clip = made_clip(step, **made)
    return replace(clip, recorded=True, bpm=bpm, clip=replace(clip.clip, sample_rate=clip.clip.sample_rate * bpm / 120))


def load(monkeypatch, clips, patch=PATCH, *, recordings=Path("recordings"), **options):
    monkeypatch.setattr(show_clips, "load_folder", lambda folder: clips)
    return load_from_patch(parse_patch(patch, "show.toml"), HERE, recordings=recordings, **options)


def test_recordings_far_from_the_tempo_are_danced_at_half_time(monkeypatch):
    loaded = load(monkeypatch, [recorded("sway", 70), recorded("spin", 75, turn=2 * np.pi), recorded("phrase", 100)])
    library = loaded.graph.library
    lengths = {clip.step: clip.measures for clip in library.clips}
    assert lengths == {"sway": 2, "spin": 2, "phrase": 1}
    assert "step 'sway', recorded at 70 bpm, is danced at half time where the show is at 120 bpm" in loaded.notes
    loaded.start()


def test_step_that_fits_no_tempo_is_left_out_with_reason(monkeypatch):
    loaded = load(monkeypatch, [recorded("slow", 40), recorded("sway", 110), recorded("spin", 130, turn=2 * np.pi)])
    assert loaded.graph.library.steps == ("sway", "spin")
    (note,) = loaded.notes
    assert "step 'slow' (slow) was recorded at 40 bpm and the show is at 120 bpm, 3 times its tempo" in note
    loaded.start()


def test_recordings_that_fit_no_tempo_at_all_are_refused(monkeypatch):
    with pytest.raises(PersonError, match=r"no step can be danced: step 'slow' .* play it at 14 to 112 bpm"):
        load(monkeypatch, [recorded("slow", 40)])


def test_group_that_names_a_refused_step_learns_why(monkeypatch):
    patch = PATCH.replace('"spin", "phrase"]', '"slow"]')
    loaded = load(monkeypatch, [*made_steps(), recorded("slow", 40)], patch, recordings=None)
    with pytest.raises(
        PersonError, match=r"group 'front': step 'slow' \(slow\) was recorded at 40 bpm and the show is"
    ):
        loaded.start()


def test_tempo_given_beside_the_patch_counts(monkeypatch):
    clips = [recorded("sway", 60), recorded("spin", 60, turn=2 * np.pi)]
    assert load(monkeypatch, clips, tempo=ShowTempo(60)).graph.library.clips[0].measures == 1
    assert load(monkeypatch, clips, tempo=ShowTempo(share=0.5)).graph.library.clips[0].measures == 1
    both = load(monkeypatch, clips, tempo=ShowTempo(60, 120))
    assert sorted(clip.measures for clip in both.graph.library.clips) == [1, 1, 2, 2]


def test_music_map_gives_the_tempo_without_its_rubato(monkeypatch):
    times = np.cumsum([0.0, *[2.0] * 30, 9.0, *[1.0] * 30])  # 120 bpm, a fermata, 240 bpm
    lines = "".join(f"[[music.line]]\ntime_s = {time}\nmeasure = {n + 1}\n" for n, time in enumerate(times.tolist()))
    patch = parse_patch(PATCH + lines, "show.toml")
    assert ShowTempo().span(patch) == pytest.approx((120.0, 240.0))
    assert ShowTempo(own_music=False).span(patch) == (120.0, 120.0)


def test_replay_finds_the_forms_that_were_danced(monkeypatch):
    """A journal keeps names of clips; the tempo that was given on the command line is not needed."""
    clips = [recorded("sway", 60), recorded("spin", 64, turn=2 * np.pi)]
    before = load(monkeypatch, clips, tempo=ShowTempo(60, 120))
    names = [clip_key(clip) for clip in before.graph.library.clips]
    again = load(monkeypatch, clips, names=names)
    assert library_hash(again.graph.library) == library_hash(before.graph.library)


def show_of(clips, *, steps=None):
    graph = build_graph(build_library(clips), threshold=0.3)
    names = ", ".join(f'"{name}"' for name in steps or graph.library.steps)
    group = f'[[group]]\nname = "a"\ndancers = 4\nsteps = [{names}]\nchoose = "random"\n'
    patch = f'name = "t"\nseed = 3\n[clock]\nbpm = 90\n{group}'
    return assemble(parse_patch(patch, "show.toml"), graph)


def dance(show, seconds, tempo=None):
    """The clips that dancers begin while a show goes on; `tempo` [bpm] is set first."""
    begun, first = [], round(show.time / TICK)
    if tempo is not None:
        assert show.apply(SetTempo(time=show.time, source="test", tempo=tempo))
    for number in range(first + 1, first + 1 + round(seconds / TICK)):
        if show.tick(number * TICK):
            library = show.dancers.graph.library
            begun += [library.clips[library.node_clip[node]] for node in show.dancers.node]
    return begun


@pytest.mark.long
def test_dancers_choose_the_form_that_fits_the_present_tempo():
    clips = tempo_forms([recorded("sway", 90), recorded("spin", 90, turn=2 * np.pi)], (90.0, 180.0)).clips
    show = show_of(clips)
    assert {clip.measures for clip in dance(show, 12.0)} == {1}
    assert show.scheduler.tempo_report(show.follower.tempo) == []
    dance(show, 5.0, tempo=180.0)
    assert {clip.measures for clip in dance(show, 12.0)} == {2}
    assert show.scheduler.tempo_report(show.follower.tempo) == []


@pytest.mark.long
def test_chance_prefers_steps_near_the_present_tempo():
    show = show_of([recorded("sway", 90), recorded("spin", 160, turn=2 * np.pi)])
    assert {clip.step for clip in dance(show, 16.0)} == {"sway"}
    dance(show, 5.0, tempo=180.0)
    assert {clip.step for clip in dance(show, 16.0)} == {"spin"}


@pytest.mark.long
def test_show_goes_on_at_an_impossible_tempo_and_says_so():
    show = show_of([recorded("sway", 90)])
    danced = dance(show, 10.0, tempo=200.0)
    assert {clip.step for clip in danced} == {"sway"}
    (row,) = show.scheduler.tempo_report(show.follower.tempo)
    assert row == {"step": "sway", "form": "", "times": 2.22, "bpm": 90.0, "dancers": 4}
    assert tempo_line([row]) == (
        "tempo: 'sway', recorded at 90 bpm, is danced 2.22 times as fast (0.7 to 1.4 is possible) by 4: choose another "
        "step or tempo",
    )
    half = show_of(tempo_forms([recorded("sway", 60)], (120.0, 120.0)).clips)
    dance(half, 10.0, tempo=200.0)
    (row,) = half.scheduler.tempo_report(half.follower.tempo)
    assert row == {"step": "sway", "form": "half time", "times": 1.67, "bpm": 60.0, "dancers": 4}
    assert "recorded at 60 bpm, is danced at half time 1.67 times as fast" in tempo_line([row])[0]
    assert tempo_line([]) == ()


def test_every_form_of_the_limits_is_near_its_tempo():
    """`all_forms` and the limits tile every tempo: one of the forms of a clip is always within them."""
    forms = list(all_forms([recorded("sway", 100)]))
    for bpm in np.geomspace(36.0, 279.0, 50):
        ratios = [bpm / form.bpm for form in forms]
        assert any(TEMPO_LIMITS[0] <= ratio <= TEMPO_LIMITS[1] for ratio in ratios)
