"""BeatScheduler: events fire in beat order at the tick that contains their beat, and lateness is counted."""

import random

from live.control.events.events import Signal
from live.show.score.beat_scheduler import MAX_PER_TICK, MAX_WAITING, BeatScheduler


def signal(name, source="score"):
    return Signal(time=0.0, source=source, name=name)


def test_events_fire_in_order_at_the_tick_of_their_beat():
    chance = random.Random(4)
    beats = [chance.uniform(0.0, 20.0) for _ in range(300)]
    agenda = BeatScheduler()
    for beat in beats:
        agenda.schedule(beat, signal(f"{beat!r}"))
    came, before = [], -0.1
    for tick in range(1000):
        now = tick * 0.03
        for event in agenda.fire(now):
            assert before < float(event.name) <= now
            came.append(float(event.name))
        before = now
    assert came == sorted(beats)
    assert (agenda.fired, agenda.late_ticks_max, agenda.late, len(agenda)) == (300, 0, 0, 0)


def test_events_of_one_beat_keep_their_order():
    agenda = BeatScheduler()
    for name in "abcde":
        agenda.schedule(2.0, signal(name))
    assert [event.name for event in agenda.fire(2.0)] == list("abcde")


def test_lateness_is_counted_in_ticks():
    agenda = BeatScheduler()
    agenda.fire(1.0)
    agenda.fire(1.1)
    for n in range(MAX_PER_TICK + 1):
        agenda.schedule(1.15, signal(str(n)))
    agenda.fire(1.2)
    assert agenda.late_ticks_max == 0
    agenda.fire(1.3)  # the one that found no room
    assert (agenda.late_ticks_max, agenda.late) == (1, 0)
    for n in range(2 * MAX_PER_TICK + 1):
        agenda.schedule(1.35, signal(str(n)))
    for now in (1.4, 1.5, 1.6):
        agenda.fire(now)
    assert (agenda.late_ticks_max, agenda.late) == (2, 1)


def test_event_scheduled_in_the_past_fires_at_once_without_lateness():
    agenda = BeatScheduler()
    agenda.fire(4.0)
    agenda.schedule(1.0, signal("over"))
    assert [event.name for event in agenda.fire(4.1)] == ["over"]
    assert agenda.late_ticks_max == 0


def test_events_of_one_source_are_removed_from_a_beat_on():
    agenda = BeatScheduler()
    for beat in range(6):
        agenda.schedule(float(beat), signal(str(beat)))
        agenda.schedule(float(beat), signal(f"hand {beat}", source="osc"))
    assert agenda.remove("score", 3.0) == 3
    assert [event.name for event in agenda.fire(9.0)] == [
        "0", "hand 0", "1", "hand 1", "2", "hand 2", "hand 3", "hand 4", "hand 5",
    ]  # fmt: skip


def test_events_beyond_capacity_are_dropped_and_counted():
    agenda = BeatScheduler()
    for _ in range(MAX_WAITING + 3):
        agenda.schedule(1.0, signal("x"))
    assert (len(agenda), agenda.dropped) == (MAX_WAITING, 3)
