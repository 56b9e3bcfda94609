"""Events to a follower, as the show gives them."""

from live.clock.follow import TimelineFollower
from live.control.events import BeatHeard, ControlEvent, SourceChanged


def follow(follower: TimelineFollower, event: ControlEvent) -> None:
    """One event out of the inbox."""
    match event:
        case BeatHeard():
            follower.heard(
                event.beat_time, event.period, event.confidence, event.time,
                source=event.source, beat=event.beat, beats_per_measure=event.beats_per_measure,
                measure=event.measure, jump=event.jump, anchored=event.anchored,
            )  # fmt: skip
        case SourceChanged(state="lost"):
            follower.lost(event.time, event.source)
        case SourceChanged(state="found"):
            follower.found(event.time, event.source)


def set_tempo(follower: TimelineFollower, bpm: float, now: float) -> None:
    """The musician's hand."""
    follower.set_tempo(bpm, now)
