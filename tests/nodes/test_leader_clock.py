"""The leader's clock, estimated over a network that jitters, by a clock that drifts and is seconds off."""

import random

import pytest

from live.nodes.leader_clock import Exchange, LeaderClock


def exchanges(clock, begin, seconds, *, offset, drift, jitter, seed=1, asymmetry=0.0):
    """Exchange time stamps four times a second; return the worst error [s] of the estimate while it was ready."""
    chance, worst, t = random.Random(seed), 0.0, begin
    while t < begin + seconds:
        there, back = (0.001 + chance.random() * jitter for _ in range(2))
        there += asymmetry
        if chance.random() < 0.01:
            there += 0.2  # lost and sent again
        leader = [(t + way) * (1.0 + drift) + offset for way in (there, there + 1e-4)]
        arrived = t + there + 1e-4 + back
        clock.add(Exchange.of(t, leader[0], leader[1], arrived))
        if clock.ready:
            worst = max(worst, abs(clock.leader(arrived) - (arrived * (1.0 + drift) + offset)))
        t += 0.25
    return worst


def test_drifting_clock_that_is_seconds_off_is_followed_within_a_millisecond():
    clock = LeaderClock()
    exchanges(clock, 100.0, 10.0, offset=-2.0, drift=1e-4, jitter=0.005)
    worst = exchanges(clock, 110.0, 600.0, offset=-2.0, drift=1e-4, jitter=0.005, seed=2)
    assert worst < 0.001
    assert clock.rate == pytest.approx(1e-4, abs=2e-5)
    assert 0.0 < clock.error < 0.001


def test_estimate_is_used_from_the_sixth_exchange_on():
    clock = LeaderClock()
    for number in range(6):
        assert not clock.ready
        clock.add(Exchange.of(number * 0.03, 7.0 + number * 0.03, 7.0 + number * 0.03, number * 0.03 + 0.002))
    assert clock.ready
    assert clock.leader(0.2) == pytest.approx(7.2 - 0.001, abs=1e-4)


def test_clock_that_jumps_is_learnt_anew():
    clock = LeaderClock()
    exchanges(clock, 0.0, 20.0, offset=1.0, drift=0.0, jitter=0.002)
    exchanges(clock, 20.0, 5.0, offset=9.0, drift=0.0, jitter=0.002)
    assert clock.offset(25.0) == pytest.approx(9.0, abs=0.002)


def test_single_wrong_answers_change_nothing():
    clock = LeaderClock()
    exchanges(clock, 0.0, 20.0, offset=1.0, drift=0.0, jitter=0.002)
    before = clock.offset(20.0)
    for wrong in (Exchange(20.0, 500.0, 0.003), Exchange(20.0, 1.0, -0.5), Exchange(20.0, 1.0, 30.0)):
        clock.add(wrong)
    assert clock.offset(20.0) == before
