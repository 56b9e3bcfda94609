"""Tests of the audience's caption in the picture: bars as long as the shares, a name without a bar, nothing without."""

import moderngl
import numpy as np
import pytest

from live.base.stage_snapshot import Camera, Scene, StageView
from live.motion.skeleton import JOINT_COUNT
from live.render.passes.caption_pass import CaptionPass
from live.render.uniforms import FrameUniforms

pytestmark = pytest.mark.gl
SIZE = (640, 360)


class Captions:
    """Draws captions over black with one pass."""

    def __init__(self, ctx):
        self._frame = FrameUniforms(ctx, Scene((10.0, 8.0), Camera(), 0, JOINT_COUNT), SIZE)
        self._target, self._drawn = ctx.simple_framebuffer(SIZE), CaptionPass(ctx, SIZE)
        self._view = StageView.allocate(0, JOINT_COUNT)

    def draw(self, *lines, level=1.0, brightness=1.0):
        """The brightness of the picture, (H, W), row 0 on top."""
        view = self._view
        view.caption, view.caption_level, view.brightness = lines, level, brightness
        self._frame.write(view)
        self._target.clear(0.0, 0.0, 0.0, 1.0)
        self._drawn.draw(view, self._target)
        pixels = np.frombuffer(self._target.read(components=3, alignment=1), np.uint8).reshape(SIZE[1], SIZE[0], 3)
        return np.flipud(pixels).max(axis=2).astype(int)

    def release(self):
        for each in (self._drawn, self._target, self._frame):
            each.release()


@pytest.fixture
def captions(gl_context: moderngl.Context):
    made = Captions(gl_context)
    yield made
    made.release()


def bars(picture, above=100):
    """The lengths of the longest row of light of each bar [pixels], from above."""
    lengths = []
    for row in picture > above:
        runs = np.diff(np.flatnonzero(np.diff(np.concatenate([[0], row, [0]]))))[::2]
        lengths.append(max(runs, default=0))
    found, before = [], 0
    for length in lengths:
        if length > 25 and before <= 25:
            found.append(length)
        elif length > 25:
            found[-1] = max(found[-1], length)
        before = length
    return found


def test_bars_are_as_long_as_shares_low_in_the_middle(captions):
    picture = captions.draw(("sway", 0.25), ("spin", 0.75))
    short, long = bars(picture)
    assert long == pytest.approx(3 * short, rel=0.06)
    rows, columns = np.nonzero(picture > 20)
    assert rows.min() > 0.6 * SIZE[1]
    assert rows.max() < 0.95 * SIZE[1]
    assert columns.mean() == pytest.approx(SIZE[0] / 2, abs=0.1 * SIZE[0])
    assert bars(captions.draw(("sway", 0.5), ("spin", 0.5))) == pytest.approx([2 * short, 2 * short], abs=2)


def test_winner_is_a_name_without_bar_and_fades(captions):
    bright = captions.draw(("spin", -1.0))
    assert bars(bright) == []
    assert bright.max() > 230
    assert (bright > 100).sum() > 100
    faint = captions.draw(("spin", -1.0), level=0.3)
    assert 40 < faint.max() < 110
    assert captions.draw(("spin", -1.0), brightness=0.0).max() == 0  # a blackout is black
    assert captions.draw().max() == 0


def test_long_and_hostile_names_stay_within_the_picture(captions):
    for name in ("x" * 5000, "<b>" * 40, "\u202e\U0001f600\n\x00", "振付"):
        picture = captions.draw((name, 0.4), (name, 0.6), ("", 0.0))
        assert picture[:, :10].max() == picture[:, -10:].max() == 0
        assert picture.max() > 150
