"""The flash limit against strobes of many kinds, checked with an independent flash counter."""

import itertools

import numpy as np
import pytest

from live.render.outputs.photosensitivity import CELLS, RED_CHANGE, FlashLimit, FlashLimiter, FlashMeter

COUNT = CELLS[0] * CELLS[1]


def count_flashes(times, shown):
    """Maximum number of flashes within any second: pairs of opposing changes of one brightness curve.

    From the definition: extremes that differ by a tenth or more, the darker one below 0.8.
    """
    turns, extreme, side = [], shown[0], 0
    for time, value in zip(times[1:], shown[1:], strict=True):
        way = 1 if value > extreme else -1
        if side in (0, way) and (side or abs(value - extreme) >= 0.1):
            side, extreme = way, value
        if side and abs(value - extreme) >= 0.1 and min(value, extreme) < 0.8:
            turns.append(time)
            side, extreme = -side, value
    return max((sum(t <= other < t + 1.0 - 1e-9 for other in turns) for t in turns), default=0) // 2


def limit_pictures(pictures, rate=60.0, *, bypass=False):
    """Limited pictures (n, cells), each processed in turn."""
    limit, left = FlashLimit(pictures.shape[1]), np.ones(len(pictures))
    for n, row in enumerate(pictures):
        if not bypass:
            left[n] = limit.max_light(n / rate, row)
        limit.record(n / rate, row * left[n])
    return pictures * left[:, None], left, limit


def strobe(hertz, seconds=6.0, rate=60.0, low=0.0, high=1.0, share=0.5):
    time = np.arange(round(seconds * rate)) / rate
    on = (time * hertz) % 1.0 < share
    return np.where(on, high, low)[:, None] * np.ones(COUNT)


@pytest.mark.parametrize("rate", [30.0, 60.0, 120.0])
@pytest.mark.parametrize("hertz", [4, 5, 7.3, 10, 15, 20, 29])
@pytest.mark.parametrize(("low", "high"), [(0.0, 1.0), (0.3, 0.6), (0.05, 0.2)])
def test_strobe_is_limited_to_three_flashes_per_second(hertz, rate, low, high):
    pictures = strobe(min(hertz, rate / 2 - 1), rate=rate, low=low, high=high)
    shown, left, _ = limit_pictures(pictures, rate)
    times = np.arange(len(shown)) / rate
    assert count_flashes(times, pictures[:, 0]) > 3  # the strobe is one
    assert count_flashes(times, shown[:, 0]) <= 3
    assert left.min() < 1.0


def test_three_flashes_per_second_are_unchanged():
    for hertz in (0.5, 1.0, 2.0, 2.9, 3.0):
        _, left, _ = limit_pictures(strobe(hertz))
        assert np.all(left == 1.0)


@pytest.mark.parametrize("dark", [1, 3, 6])
@pytest.mark.parametrize("bright", [1, 3, 6])
def test_short_flashes_are_counted_once_each(dark, bright):
    """Light and dark so short that a rise and a fall lie within one frame: three of them pass, not one."""
    curve = np.ones(120)
    for begin in (10, 26, 42, 58):
        curve[begin : begin + dark] = 0.0
        curve[begin + dark + bright :] = 0.0 if bright < 6 and begin == 58 else 1.0
    shown, left, _ = limit_pictures(curve[:, None] * np.ones(COUNT))
    assert np.all(left[: 58 + dark] == 1.0)
    assert left[58 + dark] < 0.1  # the fourth within a second
    assert count_flashes(np.arange(len(curve)) / 60.0, shown[:, 0]) <= 3


def test_small_or_bright_changes_are_not_flashes():
    assert np.all(limit_pictures(strobe(10.0, low=0.5, high=0.59))[1] == 1.0)
    assert np.all(limit_pictures(strobe(10.0, low=0.82, high=1.0))[1] == 1.0)


def test_strobe_is_limited_on_third_but_not_fifth_of_picture():
    for part, held in ((0.2, False), (0.33, True)):
        pictures = strobe(8.0)
        pictures[:, int(part * COUNT) :] = 0.3
        assert bool(limit_pictures(pictures)[1].min() < 1.0) is held


def test_random_light_never_exceeds_three_flashes():
    draw = np.random.default_rng(4)
    for _ in range(30):
        steps = draw.integers(1, 14, 200)
        curve = np.concatenate([np.full(n, draw.uniform()) for n in steps])[:900]
        shown, _, _ = limit_pictures(curve[:, None] * np.ones(24))
        assert count_flashes(np.arange(len(curve)) / 60.0, shown[:, 0]) <= 3


def test_full_light_returns_after_strobe_ends():
    pictures = np.concatenate([strobe(12.0, 2.0), np.full((180, COUNT), 0.6)])
    shown, left, _ = limit_pictures(pictures)
    assert left[:120].min() < 0.3
    assert np.all(left[-110:] == 1.0)
    assert np.all(shown[-110:] == 0.6)


def test_bypassed_limit_shows_full_light():
    _, left, limit = limit_pictures(strobe(12.0), bypass=True)
    assert np.all(left == 1.0)
    assert limit.is_watching


def test_limit_is_idle_without_changes():
    _, _, calm = limit_pictures(np.full((120, COUNT), 0.4))
    assert not calm.is_watching


def test_meter_measures_light_and_red_per_cell(gl_context):
    values = np.random.default_rng(2).integers(0, 256, (CELLS[1], CELLS[0], 3), dtype=np.uint8)
    whole = np.repeat(np.repeat(values, 20, axis=0), 20, axis=1)
    opaque = np.dstack([whole, np.full(whole.shape[:2], 255, np.uint8)])
    texture = gl_context.texture((whole.shape[1], whole.shape[0]), 4, opaque.tobytes())
    dark = gl_context.texture((64, 36), 4, bytes(64 * 36 * 4))
    meter = FlashMeter(gl_context)
    expected = ((values / 255.0) ** 2.2) @ (0.2126, 0.7152, 0.0722)
    meter.measure(texture)
    light = (values / 255.0) ** 2.2
    red = np.where(light[..., 0] >= 0.8 * light.sum(axis=2), light[..., 0] - light[..., 1] - light[..., 2], 0.0)
    assert 0 < np.count_nonzero(red) < red.size
    np.testing.assert_allclose(meter.current(), [expected.ravel(), red.ravel()], atol=1e-3)
    meter.measure(dark)
    np.testing.assert_allclose(meter.previous()[0], expected.ravel(), atol=1e-3)
    assert not np.any(meter.current())
    for thing in (meter, texture, dark):
        thing.release()


def test_limit_is_deterministic():
    pictures = np.random.default_rng(6).uniform(size=(300, COUNT)).repeat(2, axis=0)
    for one, other in itertools.pairwise([limit_pictures(pictures)[1] for _ in range(3)]):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("hertz", [5.0, 10.0, 15.0, 30.0])
def test_limiter_output_has_at_most_three_flashes_per_second(gl_context, hertz):
    """Real pictures, most of them measured only after they were shown."""
    black, white = (gl_context.texture((64, 36), 4, bytes([value]) * (64 * 36 * 4)) for value in (0, 255))
    guard = FlashLimiter(gl_context)
    times = np.arange(180) / 60.0
    lit = np.round(times * hertz * 2.0).astype(int) % 2 == 1
    shown = [guard.allowed_light(white if on else black, time) * on for on, time in zip(lit, times, strict=True)]
    assert count_flashes(times, lit.astype(float)) > 3
    assert count_flashes(times, shown) <= 3
    assert guard.dimmed_count > 20
    for thing in (guard, black, white):
        thing.release()


def test_dark_saturated_red_flashes_are_limited(gl_context):
    """A deep red: luminance changes by less than a tenth, R - G - B by more than a sixteenth."""
    black, red = (gl_context.texture((64, 36), 4, bytes([value, 0, 0, 255]) * (64 * 36)) for value in (0, 160))
    guard = FlashLimiter(gl_context)
    times = np.arange(180) / 60.0
    lit = np.round(times * 16.0).astype(int) % 2 == 1
    light = (160 / 255.0) ** 2.2
    assert 0.2126 * light < 0.1 < light
    shown = [light * guard.allowed_light(red if on else black, time) * on for on, time in zip(lit, times, strict=True)]
    scaled = np.array(shown) * (0.1 / RED_CHANGE)  # so that a sixteenth counts as a tenth
    assert count_flashes(times, lit * light * (0.1 / RED_CHANGE)) > 3
    assert count_flashes(times, scaled) <= 3
    for thing in (guard, black, red):
        thing.release()
