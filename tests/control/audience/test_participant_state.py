"""Tests of the combined force of all voices: one phone, crowds, bans, and properties for any audience."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.control.audience.participant_state import FADE_HALF_LIFE, FRESH_SECONDS, Voices
from live.control.audience.phone_protocol import ATTRACT, REPEL
from live.control.audience.voice_report import HIGHLIGHT_SECONDS, HighlightRotation
from live.control.audience.voice_sketch import BANDWIDTH

HALF = (6.0, 4.0)


def make_voices(points, *, mode=ATTRACT, joined=None, now=10.0):
    """Voices of phones that touch the points (x, z) [m], out of `joined` phones."""
    voices = Voices(4096)
    voices.update_rules((), (), HALF)
    for number, (x, z) in enumerate(points, start=1):
        row = voices.add(number, 0, allowed=True)
        voices.mode[row], voices.x[row], voices.z[row] = mode, x, z
        voices.touching[row], voices.message_time[row] = True, now
    for number in range(len(points), joined or 0):
        voices.add(number + 1, 0, allowed=True)
    return voices


def sample_points(count, x, z, spread=0.4, seed=5):
    return np.random.default_rng(seed).normal((x, z), spread, (count, 2)).tolist()


def test_thousand_phones_form_one_place_at_their_median():
    points = sample_points(1000, 2.0, -1.0)
    force = make_voices(points).sketch(10.0).force()
    assert force.share == 1.0
    assert len(force.places) == 1
    place = force.places[0]
    middle = np.median(points, axis=0)  # another robust estimate of the same
    assert np.hypot(place.x - middle[0], place.z - middle[1]) < 0.1


def test_single_outlier_among_thousand_phones_has_no_place():
    points = sample_points(1000, 2.0, -1.0)
    calm = make_voices(points).sketch(10.0).force().places[0]
    for x, z in ((-5.9, 3.9), (2.0, 1.5), (5.9, -3.9)):
        disturbed = make_voices([*points, (x, z)]).sketch(10.0).force()
        assert len(disturbed.places) == 1
        assert np.hypot(disturbed.places[0].x - calm.x, disturbed.places[0].z - calm.z) < 0.01


def test_force_share_depends_on_joined_phones():
    assert make_voices([(3.0, 0.0)], joined=1000).sketch(10.0).force().share < 0.001
    assert make_voices([(3.0, 0.0)]).sketch(10.0).force().share == 1.0
    assert make_voices(sample_points(50, 1.0, 1.0), joined=1000).sketch(10.0).force().share == 1.0


def test_two_crowds_form_places_by_size_and_mode():
    voices = make_voices(sample_points(200, -4.0, 0.0) + sample_points(100, 4.0, 0.0), joined=300)
    for row in range(200, 300):
        voices.mode[row] = REPEL
    places = voices.sketch(10.0).force().places
    assert [place.mode for place in places] == [ATTRACT, REPEL]
    assert places[0].weight == 1.0
    assert places[1].weight == pytest.approx(0.5, abs=0.03)
    assert [round(place.x) for place in places] == [-4, 4]


def test_voice_fades_to_zero_after_touch_ends():
    voices = make_voices([(1.0, 0.0)])
    assert voices.weights(10.0 + FRESH_SECONDS)[0] == 1.0
    voices.touching[0], voices.message_time[0] = False, 11.0
    assert voices.weights(11.0 + FADE_HALF_LIFE)[0] == pytest.approx(0.5)
    assert voices.weights(11.0 + 10 * FADE_HALF_LIFE)[0] == 0.0
    assert voices.sketch(30.0).force().places == ()


def test_regions_have_operator_weights_and_banned_phones_none():
    voices = make_voices(sample_points(10, 3.0, 0.0) + sample_points(5, -3.0, 0.0))
    voices.region[10:] = 1
    voices.update_rules((0.5, 2.0), (), HALF)
    places = voices.sketch(10.0).force().places
    assert [round(place.x) for place in places] == [-3, 3]
    assert places[1].weight == pytest.approx(0.5, abs=0.05)
    voices.update_rules((0.5, 2.0), tuple(range(11, 16)), HALF)
    assert [round(place.x) for place in voices.sketch(10.0).force().places] == [3]
    voices.update_rules((), (), HALF)  # a patch without regions: all weigh the same
    assert voices.sketch(10.0).force().places[0].x > 0


@given(st.lists(st.tuples(st.floats(-6, 6), st.floats(-4, 4)), min_size=1, max_size=60), st.integers(0, 100))
def test_places_weights_and_order_properties_hold(points, more):
    """Places lie among the voices of their kind; weights are relative to the largest; order does not matter."""
    force = make_voices(points, joined=len(points) + more).sketch(10.0).force()
    assert 0.0 < force.share <= 1.0
    assert force.places[0].weight == 1.0
    for place in force.places:
        assert 0.3 <= place.weight <= 1.0
        assert min(np.hypot(place.x - x, place.z - z) for x, z in points) < BANDWIDTH
    turned = make_voices(points[::-1], joined=len(points) + more).sketch(10.0).force()
    np.testing.assert_allclose(
        sorted((p.x, p.z) for p in turned.places), sorted((p.x, p.z) for p in force.places), atol=1e-6
    )


def test_removed_voice_frees_its_row():
    voices = Voices(3)
    rows = [voices.add(number, 0, allowed=True) for number in (1, 2, 3)]
    assert voices.add(4, 0, allowed=True) == -1
    voices.remove(rows[1])
    assert voices.count == 2
    assert voices.add(5, 0, allowed=True) == rows[1]


def test_each_phone_is_highlighted_in_turn():
    lights, seen = HighlightRotation(4), {}
    speaking = list(range(20))
    for step in range(int(8 * HIGHLIGHT_SECONDS / 0.05)):
        lights.update(speaking, 0.05 * step)
        assert len(lights.rows) == 4
        for row in lights.rows:
            seen[row] = seen.get(row, 0) + 1
    assert set(seen) == set(speaking)
    assert min(seen.values()) * 0.05 > HIGHLIGHT_SECONDS / 2
    lights.update([7], 1e3)
    assert lights.rows == [7]
    lights.update([], 1e3)
    assert lights.rows == []
