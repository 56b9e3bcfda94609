"""Handling of clock events by the timeline follower."""

import math
from typing import Final

from live.clock.follower.manual_control import TrackerHint
from live.clock.follower.timeline_follower import TimelineFollower
from live.control.events import events
from live.control.events.events import ControlEvent
from live.show.patch.patch import Patch

CLOCK_EVENTS: Final = (
    events.BeatHeard, events.SourceChanged, events.Tap, events.One, events.SetTempo, events.Nudge, events.ShiftBeats,
    events.ScaleTempo, events.TakeRunnerUp, events.HoldTempo, events.SetMetre, events.CountIn, events.ChooseSource,
)  # fmt: skip
"""The events for the follower."""


def make_follower(patch: Patch, tempo: float | None) -> TimelineFollower:
    """Return the follower of a show. `tempo` [bpm] overrides the patch's, for music other than the patch's."""
    clock, music = patch.clock, patch.music
    return TimelineFollower(
        tempo=tempo or clock.bpm,
        beats_per_measure=clock.beats_per_measure,
        one_at=music.first_downbeat if tempo is None else None,
        known_tempo=music.known_tempo if tempo is None else None,
        priority=clock.priority,
        tempo_range=clock.tempo_range,
        follow_metre=clock.follow_metre,
    )


def initial_seeds(follower: TimelineFollower, *, follow_metre: bool, known_tempo: float | None) -> list[TrackerHint]:
    """Return the seeds of a beat tracker at the start; `known_tempo` [bpm] is that of the patch's own music.

    The position of that music's first downbeat is not among them: its player reports it later, in audio time.
    """
    seeds = []
    if not follow_metre:
        seeds.append(TrackerHint("metre", 0.0, float(follower.timeline.beats_per_measure)))
    if known_tempo is not None:
        seeds.append(TrackerHint("tempo", math.nan, known_tempo))
    return seeds


def apply_clock_event(follower: TimelineFollower, event: ControlEvent) -> str:
    """Apply an event of CLOCK_EVENTS; return the reason if it was refused, else ""."""
    refused = follower.refused
    match event:
        case events.BeatHeard() | events.SourceChanged():
            _apply_observation(follower, event)
        case events.Tap():
            follower.tap(event.time)
        case events.One():
            follower.set_downbeat(event.time)
        case events.SetTempo():
            follower.set_tempo(event.tempo, event.time)
        case _:
            _apply_manual(follower, event)
    return follower.refusal if follower.refused > refused else ""


def _apply_manual(follower: TimelineFollower, event: ControlEvent) -> None:
    match event:
        case events.Nudge():
            follower.nudge(event.seconds, event.time)
        case events.ShiftBeats():
            follower.shift_beats(event.beats, event.time)
        case events.TakeRunnerUp():
            follower.take_runner_up(event.time)
        case events.ScaleTempo():
            follower.scale_tempo(event.factor, event.time)
        case events.HoldTempo():
            follower.hold(event.on, event.time)
        case events.SetMetre():
            follower.set_metre(event.beats, event.time)
        case events.CountIn():
            follower.count_in(event.measures, event.time)
        case events.ChooseSource():
            follower.select_source(event.name)


def _apply_observation(follower: TimelineFollower, event: events.BeatHeard | events.SourceChanged) -> None:
    match event:
        case events.BeatHeard():
            follower.observe(
                event.beat_time,
                event.period,
                event.confidence,
                event.time,
                source=event.source,
                beat=event.beat,
                beats_per_measure=event.beats_per_measure,
                measure=event.measure,
                jump=event.jump,
                anchored=event.anchored,
                runner_up=event.runner_up,
                runner_up_share=event.runner_up_share,
            )
        case events.SourceChanged(state="lost"):
            follower.lost(event.time, event.source)
        case events.SourceChanged(state="silent" | "stopped"):
            follower.silent(event.time, event.source)
        case events.SourceChanged(state="paused"):
            follower.paused(event.time, event.source)
        case events.SourceChanged(state="found" | "started"):
            follower.found(event.time, event.source)
