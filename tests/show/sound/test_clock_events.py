"""Clock events of a show: their effects on dance, status and journal."""

from collections import Counter, deque

import numpy as np
import pytest

from live.base.event_queue import EventQueue
from live.clock.ticks import TICK
from live.clock.time_source import ManualClock
from live.control.audio.analysis import AudioAnalysis
from live.control.audio.music_file import Music, OfflineMusic
from live.control.audio.music_player import MusicPlayer
from live.control.events import events
from live.control.events.audio import MusicHeard
from live.show.engine import Engine
from live.show.journal.journal import JournalWriter, read_journal
from live.show.journal.replay import replay
from live.show.patch.patch_reader import parse_patch
from live.show.patch.patch_search_path import PatchError
from live.show.sound.clock_commands import CLOCK_EVENTS
from live.show.view.status import Status
from tests.control.waiting import wait_for
from tests.fixtures.mostly_long import mostly_long
from tests.show.made_show import PATCH, made_show


def send_beat(show, beat_time, *, source="midi", period=0.5, **more):
    show.apply(events.BeatHeard(
        time=show.time, source=source, beat_time=beat_time, period=period, confidence=0.9, **more
    ))  # fmt: skip


def run(show, ticks, *, script=None):
    """Runs ticks; `script`: events by tick. Returns the largest joint motion within a tick [m]."""
    view, before, fastest = show.view(), None, 0.0
    for tick in range(round(show.time / TICK) + 1, round(show.time / TICK) + ticks + 1):
        for event in (script or {}).get(tick, ()):
            show.apply(event)
        show.tick(tick * TICK)
        show.fill(view, tick * TICK)
        if before is not None:
            fastest = max(fastest, float(np.linalg.norm(view.joint_position - before, axis=2).max()))
        before = view.joint_position.copy()
    return fastest


@mostly_long("start", [2.03, 2.4, 2.71, 3.97], quick=[])
def test_midi_start_moves_beat_without_joint_jump(start):
    show = made_show()
    fastest = run(show, round(start / TICK))
    for k in range(24):
        send_beat(show, start + 0.5 * k, beat=k % 4, beats_per_measure=4, measure=k // 4, jump=k == 0)
        fastest = max(fastest, run(show, 32))
    assert show.follower.source == "midi"
    assert (show.follower.jumps > 0) == (start in (2.4, 2.71))  # the others lie on a measure line of the show's
    assert fastest < 0.16
    at = start + 20 * 0.5
    phase = show.timeline.phase_at(at)
    assert min(phase, 4.0 - phase) < 0.01
    assert (show.span.end - show.timeline.measure_origin) % 4.0 == pytest.approx(0.0, abs=1e-6)


@pytest.mark.long
def test_other_meter_stretches_steps_without_fast_joints():
    show = made_show('[[segment]]\nmeasure = 2\nmeasures = 6\nformation = "circle"\ngroup = "front"\n')
    script = {
        tick: [events.SetMetre(time=tick * TICK, source="test", beats=beats)]
        for tick, beats in ((300, 3), (700, 5), (1000, 4))
    }
    assert run(show, 64 * 20, script=script) < 0.16
    assert show.timeline.beats_per_measure == 4
    assert show.span.number > 8


def test_manual_clock_events_are_journaled_and_replayed_exactly(tmp_path):
    def hand(kind, tick, **values):
        return tick, kind(time=tick * TICK, source="key", **values)

    script = [
        hand(events.Nudge, 100, seconds=0.02), hand(events.ShiftBeats, 200, beats=1.0),
        hand(events.ScaleTempo, 300, factor=0.5), hand(events.HoldTempo, 400, on=True),
        hand(events.SetMetre, 450, beats=3), hand(events.HoldTempo, 500, on=False),
        hand(events.CountIn, 520, measures=1.0), *[hand(events.Tap, 530 + 30 * k) for k in range(6)],
        hand(events.ChooseSource, 800, name="internal"),
    ]  # fmt: skip
    show, path = made_show(), tmp_path / "night.jsonl"
    writer = JournalWriter(path, {})
    for tick in range(1, 64 * 18):
        for when, event in script:
            if when == tick:
                writer.record_event(tick - 1, event)
                assert show.apply(event)
        if show.tick(tick * TICK):
            writer.record_measure(tick, show.span.number + 1, show.state_hash())
    writer.close(tick)
    assert show.follower.jumps >= 3
    again = replay(made_show(), read_journal(path))
    assert again.differences == ()
    assert again.measures >= 5


def synthesize_song(bpm, one, seconds, rate=44100):
    """Drums with hi-hats between the beats and a louder first of four, counted from `one` [s] both ways."""
    chance = np.random.default_rng(3)
    sound = chance.normal(0.0, 1e-4, int(seconds * rate))
    t = np.arange(int(0.15 * rate)) / rate
    kick = 0.7 * np.sin(2.0 * np.pi * (50.0 * t + 4.0 * (1.0 - np.exp(-t / 0.03)))) * np.exp(-t / 0.06)
    snare = 0.5 * chance.normal(0.0, 1.0, t.size) * np.exp(-t / 0.04)
    hat = 0.15 * np.diff(chance.normal(0.0, 1.0, t.size + 1)) * np.exp(-t / 0.01)
    for half in range(-int(2.0 * one * bpm / 60.0), int(2.0 * (seconds - one - 0.5) * bpm / 60.0)):
        start = round((one + half * 30.0 / bpm) * rate)
        hit = hat if half % 2 else (kick if half % 4 == 0 else snare)
        sound[start : start + hit.size] += hit * (1.0 if half % 8 else 1.3)
    return Music(np.stack([sound, sound], axis=1).astype(np.float32), rate)


def analysis_factory(show):
    """A factory of the analysis of a show's music: its tracker is seeded from the patch."""
    seeds = deque()
    show.seed_tracker(seeds.append)
    return lambda rate: AudioAnalysis(rate, seeds=seeds)


SLOW = "music = {one_at_s = 2.763, bpm = 64}\n"


@pytest.mark.long
@pytest.mark.parametrize(
    "begin", [pytest.param(0.0, marks=pytest.mark.long), pytest.param(0.21, marks=pytest.mark.long), 0.7]
)
def test_score_of_slow_song_starts_at_known_downbeat(tmp_path, begin):
    show, clock, inbox = made_show(SLOW, top=True), ManualClock(), EventQueue()
    music = OfflineMusic(synthesize_song(64.0, 2.763, 16.0), begin=begin, one_at=2.763, analysis=analysis_factory(show))
    writer = JournalWriter(tmp_path / "night.jsonl", {})
    status = Status(show, rejected=dict, memory=lambda: 0.0)
    engine = Engine(show, clock=clock, inbox=inbox, status=status, journal=writer)
    begins = {}
    for frame in range(60 * 12):
        clock.set(frame / 60.0)
        for event in music.events_until(frame / 60.0):
            inbox.put(event)
        engine.frame(lambda view: None)
        begins.setdefault(show.span.number + 1, show.time)
    writer.close(engine.ticks.index)
    assert show.follower.state == "locked"
    for measure in (1, 2, 3):
        assert begins[measure] == pytest.approx(begin + 2.763 + (measure - 1) * 3.75, abs=0.04), begins
    again = replay(made_show(SLOW, top=True), read_journal(tmp_path / "night.jsonl"))
    assert again.differences == ()
    assert again.measures >= 2


class AutoAdvanceClock:
    """A clock that advances by 20 ms at every reading."""

    def __init__(self):
        self.time = 0.0

    def now(self):
        self.time += 0.02
        return self.time


@pytest.mark.long
def test_music_player_announces_downbeat_once_before_beats():
    inbox = EventQueue()
    player = MusicPlayer(synthesize_song(64.0, 2.763, 8.0), inbox, AutoAdvanceClock(), output=False, one_at=2.763)
    found = []
    player.start()
    try:
        is_beat_found = lambda: any(isinstance(event, events.BeatHeard) and event.time > 6.0 for event in found)  # noqa: E731
        assert wait_for(lambda: found.extend(inbox.drain()) or is_beat_found(), 30.0)
    finally:
        player.stop()
    ones = [place for place, event in enumerate(found) if isinstance(event, events.One)]
    assert len(ones) == 1, "once: nothing has changed"
    assert found[ones[0]].time == pytest.approx(player._begin + 2.763)
    assert not any(isinstance(event, events.BeatHeard) for event in found[: ones[0]])


@pytest.mark.long
def test_late_downbeat_is_announced_at_same_position_for_any_step():
    music = synthesize_song(64.0, 32.0, 33.0, rate=16000)
    told = []
    for step in (0.1, 33.0):
        offline, found = OfflineMusic(music, one_at=32.0), []
        for turn in range(1, int(33.0 / step) + 1):
            found += [(turn * step, event) for event in offline.events_until(turn * step)]
        place = next(place for place, (_, event) in enumerate(found) if isinstance(event, events.One))
        told.append(place)
        assert found[place][0] == pytest.approx(2.0, abs=step)
        assert found[place][1].time == pytest.approx(32.0)
    assert told[0] == told[1] > 0


def test_refused_clock_events_report_their_reason():
    show = made_show()
    assert not show.apply(events.ChooseSource(time=0.0, source="osc", name="the drummer"))
    assert "the drummer" in show.refusals.last_reason
    assert not show.apply(events.SetMetre(time=0.0, source="osc", beats=1))
    for k in range(12):
        run(show, 32)
        send_beat(show, 0.5 * (k + 1), beat=k % 4, beats_per_measure=4, measure=k // 4)
    assert not show.apply(events.SetTempo(time=show.time, source="key", tempo=90.0))
    assert "midi" in show.refusals.last_reason


@pytest.mark.long
def test_status_shows_clock_source_and_pending_changes():
    show = made_show()
    status = Status(show, rejected=Counter, memory=lambda: 1.0)
    for k in range(16):
        run(show, 32)
        send_beat(show, 0.5 * (k + 1), beat=k % 4, beats_per_measure=4, measure=k // 4 + 40)
        send_beat(show, 0.5 * (k + 1) + 0.1, source="audio", beat=k % 4, beats_per_measure=4)
    show.apply(events.ChooseSource(time=show.time, source="osc", name="link"))
    show.apply(events.CountIn(time=show.time, source="osc", measures=2.0))
    run(show, 33)
    s = status.snapshot(show.time)
    assert (s["source"], s["clock_state"], s["clock_choice"]) == ("midi", "locked", "link")
    assert s["clock_sources"]["audio"] == "locked"
    assert s["clock_sources"]["link"] == "absent"
    assert s["source_measure"] == 44
    assert s["count_in"] in (7, 8)
    assert s["clock_last_jump"]["cause"] in ("one", "lines")
    line = next(line for line in status.overlay(show.time) if line.startswith("clock"))
    assert "waits for link" in line
    assert "also audio" in line
    assert "counting in" in line


def test_tracker_receives_meter_tempo_and_downbeat():
    show, told = made_show(), []
    show.seed_tracker(told.append)
    show.apply(events.SetTempo(time=0.0, source="key", tempo=96.0))
    show.apply(events.One(time=0.0, source="key"))
    assert [(seed.kind, seed.value) for seed in told] == [("metre", 4.0), ("tempo", 96.0), ("one", 0.0)]


def test_patch_sets_clock_priority_and_tempo_range():
    patch = PATCH.replace("bpm = 120", 'bpm = 120\npriority = ["audio", "midi"]\ntempo_range = [50, 110]')
    assert parse_patch(patch, "x").clock.priority == ("audio", "midi")
    for wrong in ('priority = ["audio", "audio"]', 'priority = ["drummer"]', "tempo_range = [80, 120]"):
        with pytest.raises(PatchError):
            parse_patch(PATCH.replace("bpm = 120", "bpm = 120\n" + wrong), "x")


def test_clock_events_are_registered_event_types():
    assert MusicHeard not in CLOCK_EVENTS
    assert all(cls.__name__ in events.EVENT_TYPES for cls in CLOCK_EVENTS)
