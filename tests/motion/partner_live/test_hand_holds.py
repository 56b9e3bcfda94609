"""Which hands a unit holds: from a little before, within the unit, and on at its end until the next one is clear."""

from types import SimpleNamespace

import numpy as np
import pytest

from live.motion.partner.units import Hold
from live.motion.partner_live.hand_holds import HOLD_LEAD_TIME, NOBODY, held_hands

HOLDS = (Hold(0, 1, 120.0, 150.0), Hold(1, 0, 170.0, 400.0), Hold(1, 1, 240.0, 300.0))


def at(place: float, *, known: bool = True, holds: tuple[Hold, ...] = HOLDS) -> tuple[int, int]:
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
        (150.0, (1, 0)),  # the other one is near
        (151.0, (1, NOBODY)),
        (199.0, (1, NOBODY)),
        (230.0, (1, NOBODY)),  # over, and it is held on; what her recording goes on with is nobody's answer
    ],
)
def test_a_hold_counts_from_a_little_before_to_its_end_within_the_unit(place: float, hands: tuple[int, int]) -> None:
    assert at(place) == hands


def test_nothing_is_held_before_anything_is_danced_or_where_nothing_is_written() -> None:
    assert at(135.0, known=False) == (NOBODY, NOBODY)
    assert at(135.0, holds=()) == (NOBODY, NOBODY)


def test_a_hand_keeps_what_it_holds_until_that_is_over() -> None:
    holds = (Hold(0, 1, 110.0, 150.0), Hold(1, 1, 151.0, 200.0))
    assert at(149.0, holds=holds) == (NOBODY, 0)
    assert at(151.0, holds=holds) == (NOBODY, 1)
