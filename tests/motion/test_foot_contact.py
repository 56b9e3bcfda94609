"""Tests of foot contact on synthetic feet with known contacts."""

import numpy as np
import pytest

from live.motion.foot_contact import TOES_OVER_SOLE, find_contacts
from live.motion.skeleton import SKELETON, SOLE_BELOW_ANKLE

RATE = 60.0


def feet(height: np.ndarray, x: np.ndarray | float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Ankles and toes (T, 2, 3) of two flat feet; the left follows `height` [m] and `x` [m], the right stands."""
    ankles = np.zeros((len(height), 2, 3))
    ankles[:, 0, 0], ankles[:, 0, 1] = x, height
    return ankles + np.array((0.0, SOLE_BELOW_ANKLE, 0.0)), ankles + np.array((0.0, TOES_OVER_SOLE, 0.13))


def test_flat_foot_heights_match_skeleton() -> None:
    positions = SKELETON.rest_positions()
    assert positions[SKELETON.index("leftToes"), 1] == pytest.approx(TOES_OVER_SOLE, abs=1e-6)
    assert positions[SKELETON.index("leftFoot"), 1] == pytest.approx(SOLE_BELOW_ANKLE, abs=1e-6)


def test_raised_foot_has_no_contact() -> None:
    time = np.arange(120) / RATE
    swing = np.clip((time - 0.5) / 0.4, 0.0, 1.0)
    contact = find_contacts(*feet(0.12 * np.sin(np.pi * swing), 0.6 * swing), RATE)
    assert contact[:, 1].all()
    assert contact[:28, 0].all()
    assert not contact[34:52, 0].any()
    assert contact[60:, 0].all()


def test_hovering_foot_keeps_contact_state() -> None:
    """Between both height limits the state is kept: 6 cm is contact after standing, none before landing."""
    rises = np.interp(np.arange(200), [0, 50, 150, 200], [0.0, 0.0, 0.06, 0.06])
    assert find_contacts(*feet(rises), RATE)[:, 0].all()
    sinks = np.interp(np.arange(200), [0, 50, 150, 200], [0.2, 0.2, 0.06, 0.06])
    assert not find_contacts(*feet(sinks), RATE)[:, 0].any()


def test_fast_low_foot_has_no_contact_and_slow_slide_has() -> None:
    time = np.arange(90) / RATE
    assert not find_contacts(*feet(np.full(90, 0.02), 1.0 * time), RATE)[:, 0].any()
    start_slow = np.where(time < 0.5, 0.0, 0.3 * (time - 0.5))
    assert find_contacts(*feet(np.zeros(90), start_slow), RATE)[:, 0].all()


def test_pivot_on_toes_is_contact() -> None:
    ankles, toes = feet(np.zeros(60))
    turn = np.linspace(0.0, np.pi, 60)
    ankles[:, 0] = toes[:, 0] + np.stack((0.1 * np.sin(turn), np.full(60, 0.12), -0.1 * np.cos(turn)), axis=1)
    assert find_contacts(ankles, toes, RATE)[:, 0].all()


def test_short_contact_changes_are_removed() -> None:
    height = np.zeros(120)
    height[60:62] = 0.2  # a glitch of two samples
    ankles, toes = feet(height)
    assert find_contacts(ankles, toes, RATE)[:, 0].all()
    up = np.full(120, 0.3)
    up[60:62] = 0.0
    assert not find_contacts(*feet(up), RATE)[:, 0].any()


@pytest.mark.parametrize("rate", [30.0, 60.0, 120.0])
def test_contacts_are_independent_of_sample_rate(rate: float) -> None:
    time = np.arange(round(2 * rate)) / rate
    swing = np.clip((time - 0.5) / 0.5, 0.0, 1.0)
    contact = find_contacts(*feet(0.15 * np.sin(np.pi * swing), 0.5 * swing), rate)[:, 0]
    lifted = time[~contact]
    assert 0.45 < lifted.min() < 0.6
    assert 0.9 < lifted.max() < 1.1


@pytest.mark.parametrize("samples", [1, 2, 3])
def test_short_clips_have_contact_arrays(samples: int) -> None:
    assert find_contacts(*feet(np.zeros(samples)), RATE).shape == (samples, 2)
