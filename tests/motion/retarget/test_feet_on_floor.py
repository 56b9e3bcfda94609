"""Tests of floor tracking in recordings with a jump and with a drift."""

import numpy as np

from live.motion.retarget.floor_contact import find_floor


def test_floor_ignores_jumps_and_follows_drift() -> None:
    """Jumps do not move the floor; a recording that floats for half of its time is lowered slowly."""
    time = np.arange(600) / 60.0
    jump = np.where((time > 3.0) & (time < 3.6), 0.3 * np.sin((time - 3.0) / 0.6 * np.pi), 0.0)
    np.testing.assert_allclose(find_floor(jump, 60.0), 0.0, atol=1e-9)
    drift = 0.5 * time / 10.0
    followed = drift + jump - find_floor(drift + jump, 60.0)
    assert np.abs(followed[(time < 2.0) | (time > 5.0)]).max() < 0.08
    assert followed.max() > 0.25
