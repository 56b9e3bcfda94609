"""Tests of hands held in a unit: from just before a hold to its end, within the unit, and on past its end."""

from types import SimpleNamespace

import numpy as np
import pytest

from live.motion.partner.units import Hold
from live.motion.partner_live.hand_holds import HOLD_LEAD_TIME, NOBODY, held_hands

HOLDS = (Hold(0, 1, 120.0, 150.0), Hold(1, 0, 170.0, 400.0), Hold(1, 1, 240.0, 300.0))


def hands_at_sample(place: float, *, known: bool = True, holds: tuple[Hold, ...] = HOLDS) -> tuple[int, int]:
    """Hands held at a sample of a recording at 60 Hz, in a unit from sample 100 to 200."""
    units = SimpleNamespace(
        examples=[SimpleNamespace(holds=holds)],
        example=np.array([0]),
        start=np.array([100.0]),
        length=np.array([100.0]),
    )
    reader = SimpleNamespace(units=units)
    return held_hands(SimpleNamespace(has_pose=known, unit=0, sample=place, sample_rate=60.0, decoder=reader))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("place", "hands"),
    [
        (120.0 - 60.0 * HOLD_LEAD_TIME - 1.0, (NOBODY, NOBODY)),
        (120.0 - 60.0 * HOLD_LEAD_TIME, (NOBODY, 0)),
        (135.0, (NOBODY, 0)),
        (150.0, (1, 0)),  # the second hold is within its lead time
        (151.0, (1, NOBODY)),
        (199.0, (1, NOBODY)),
        (230.0, (1, NOBODY)),  # past the end of the unit the hold continues; later holds of the recording do not count
    ],
)
def test_hold_counts_from_lead_time_to_its_end(place: float, hands: tuple[int, int]) -> None:
    assert hands_at_sample(place) == hands


def test_no_hand_is_held_without_pose_or_holds() -> None:
    assert hands_at_sample(135.0, known=False) == (NOBODY, NOBODY)
    assert hands_at_sample(135.0, holds=()) == (NOBODY, NOBODY)


def test_hand_keeps_hold_until_it_ends() -> None:
    holds = (Hold(0, 1, 110.0, 150.0), Hold(1, 1, 151.0, 200.0))
    assert hands_at_sample(149.0, holds=holds) == (NOBODY, 0)
    assert hands_at_sample(151.0, holds=holds) == (NOBODY, 1)
