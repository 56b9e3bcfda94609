"""`live render --click --taps`: the film of the tap patch contains click and tap sounds."""

import av
import numpy as np
import pytest

from tests.cli.command import run_live
from tests.cli.test_show_commands import gl_or_skip


def read_sound(film):
    """Samples of the film's sound (n, 2) in playing order, and their rate."""
    with av.open(str(film)) as container:
        stream = container.streams.audio[0]
        frames = [frame.to_ndarray() for frame in container.decode(stream)]
        return np.concatenate(frames, axis=1).T, stream.rate


@pytest.mark.long
def test_film_of_tap_patch_contains_requested_clicks_and_taps(tmp_path):
    gl_or_skip()
    films = {}
    for name, asked in (("as the patch says", ()), ("feet alone", ("--no-click",))):
        film = tmp_path / f"{len(films)}.mp4"
        result = run_live(
            "render", "tap", "--seconds", "2", "--fps", "20", "--size", "96x64", "--out", str(film), *asked
        )
        assert result.returncode == 0, result.stderr
        films[name] = film
    both, rate = read_sound(films["as the patch says"])
    feet, _ = read_sound(films["feet alone"])
    assert abs(len(both) / rate - 2.0) < 0.1
    assert (feet**2).mean() > 1e-5
    beat = 60.0 / 108.0
    # the difference of the two films is the click: a burst after every beat, almost nothing before the next one
    count = min(len(both), len(feet))
    click = (both[:count] - feet[:count]) ** 2
    for number in (1, 2, 3):
        begin = round(number * beat * rate)
        after, before = click[begin : begin + rate // 50].mean(), click[begin - rate // 20 : begin - rate // 50].mean()
        assert after > 10.0 * before
