"""Tests of ripples: a delay over a group by position or distance, eased in, set live."""

import numpy as np
import pytest

from live.base.errors import PersonError
from live.clock.ticks import TICK
from live.control.events import events
from live.show.dancers.timing_offsets import Ripple, parse_ripple
from live.show.dancers.variation import MAX_DELAY, MAX_DELAY_CHANGE
from tests.show.made_show import made_show

ROW = np.array([[-2.0, 0.0], [-1.0, 0.5], [0.0, 0.0], [2.0, -0.5]])
PLAIN = "[motion]\nwarp_beats = 0\namplitude = 0\n"
RUNS = 'ripple_beats = 2.0\nripple = "left"\n[[group]]\nname = "back"'


@pytest.mark.parametrize(
    ("words", "first", "last"),
    [("left", 0, 3), ("right", 3, 0), ("front", 1, 3), ("back", 3, 1), ("2 -0.5", 3, 0), ("-2, 0", 0, 3)],
)
def test_ripple_starts_at_given_place(words, first, last):
    delays = parse_ripple(words, 2.0).delays(ROW)
    assert delays.argmin() == first
    assert delays.argmax() == last
    assert delays.min() == 0.0
    assert delays.max() == 2.0


def test_delay_is_linear_in_position():
    delays = Ripple(2.0, "left").delays(ROW)
    assert delays == pytest.approx(2.0 * (ROW[:, 0] + 2.0) / 4.0, abs=1.0 / 32.0)


def test_center_ripple_gives_equal_delay_at_equal_distance():
    ring = np.array([[np.sin(a), np.cos(a)] for a in np.linspace(0.0, 2.0 * np.pi, 8, endpoint=False)])
    delays = Ripple(1.5, "centre").delays(np.concatenate([np.zeros((1, 2)), ring]))
    assert delays[0] == 0.0
    assert (delays[1:] == 1.5).all()


def test_group_on_one_spot_has_small_delays():
    place = np.random.default_rng(1).normal(0.0, 1e-3, (9, 2))
    assert Ripple(4.0, "left").delays(place).max() < 0.1


@pytest.mark.parametrize("words", ["", "up", "1", "1 2 3", "nan 1", "left right"])
def test_invalid_ripple_origin_is_refused(words):
    with pytest.raises(PersonError):
        parse_ripple(words, 1.0)


def phases(show, seconds, script=()):
    """Measures danced by each dancer at every tick, (ticks, A)."""
    rows = []
    for tick in range(1, round(seconds / TICK)):
        for when, event in script:
            if when == tick:
                assert show.apply(event)
        show.tick(tick * TICK)
        fraction = show.span.fraction(show.timeline.beat_at(tick * TICK))
        rows.append(show.span.number + show.dancers.phases(fraction))
    return np.array(rows)


def test_dancers_are_delayed_smoothly_by_position():
    event = events.SetRipple(time=4.0, source="test", beats=2.0, begins="left", group="front")
    show = made_show(PLAIN)
    danced = phases(show, 30.0, [(256, event)])
    behind = (danced.max(axis=1, keepdims=True) - danced) * 4.0  # beats
    assert behind[:250].max() < 1e-6
    assert behind[-1, 5:].max() < 1e-6  # the other group goes on together
    place, late = show.state.position[:5, 0], behind[-1, :5]
    assert (np.diff(late[np.argsort(place)]) > -0.3).all()
    assert late.max() == pytest.approx(2.0, abs=0.07)
    rate = np.diff(danced, axis=0) / (TICK / 2.0)
    assert rate.min() > 1.0 - 1.5 * MAX_DELAY_CHANGE - 0.01  # no dancer stops or jumps
    assert rate.max() < 1.0 + 1.5 * MAX_DELAY_CHANGE + 0.01
    assert np.abs(np.diff(rate, axis=0)).max() < 0.05


@pytest.mark.long
def test_ripple_can_be_removed_and_stays_below_maximum_delay():
    on = events.SetRipple(time=0.0, source="test", beats=16.0, begins="0 0", group="*")
    off = events.SetRipple(time=20.0, source="test", beats=0.0, begins="left", group="*")
    show = made_show(PLAIN)
    danced = phases(show, 40.0, [(1, on), (64 * 20, off)])
    behind = danced.max(axis=1, keepdims=True) - danced
    assert 0.5 < behind.max() <= MAX_DELAY + 1e-6
    assert behind[-1].max() < 1e-6


def test_patch_sets_ripple_and_invalid_events_are_refused():
    show = made_show(PLAIN + '[[group]]\nname = "wave"\ndancers = 4\nsteps = ["sway"]\nripple_beats = 1.0\n')
    phases(show, 8.0)
    assert show.variation.delays[9:].max() == pytest.approx(0.25, abs=0.02)
    assert show.variation.delays[:9].max() == 0.0
    assert not show.apply(events.SetRipple(time=8.0, source="test", beats=1.0, begins="up", group="*"))
    assert not show.apply(events.SetRipple(time=8.0, source="test", beats=1.0, begins="left", group="nobody"))
