"""Levels of detail: nobody who stands near is ever drawn with another body, and from afar it is not seen."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import ndimage

from live.base.stage_snapshot import Camera
from live.render.adaptive_quality import HARDWARE, SOFTWARE, choose_quality, quality_steps
from live.render.body.body_mesh import DISTANT, LIGHT
from live.render.dancers.dancer_batch import DancerBatch
from live.render.passes.dancer_pass import GBufferPass
from live.render.uniforms import FrameUniforms
from tests.render.poses import LUNGE, REACH, stage_view
from tests.render.test_renderer import scene

pytestmark = pytest.mark.gl
SIZE = (1280, 720)
NEAR = 3.0
"""At this distance [m] a change of the level must not be seen."""
ALLOWED = 1.5
"""Pixels by which outlines may differ where the level changes, for all but one in a hundred of their points."""


@pytest.fixture
def outline(gl_context):
    """Where dancers are seen (H, W), drawn with so much quality from a distance [m]."""

    def seen(quality, away, turns=LUNGE):
        camera = Camera(eye=(0.0, 1.0, away), target=(0.0, 0.95, 0.0), field_of_view_deg=40.0)
        view = stage_view([(turns, (0.0, 0.0), 25.0, 0)])
        frame, crowd = (
            FrameUniforms(gl_context, scene(1, camera), SIZE),
            DancerBatch(gl_context, scene(1, camera), quality, SIZE),
        )
        surface = GBufferPass(gl_context, quality, SIZE)
        frame.write(view)
        crowd.update(view, frame.light)
        surface.draw(crowd)
        mask = np.frombuffer(surface.depth.read(), np.float32).reshape(SIZE[::-1]) < 1.0
        for thing in (surface, crowd, frame):
            thing.release()
        return mask

    return seen


def apart(a, b):
    """How far the outlines of two figures lie apart [pixels], for 99 of 100 of their points."""
    edges = [mask & ~ndimage.binary_erosion(mask) for mask in (a, b)]
    far = [ndimage.distance_transform_edt(~edges[1 - k])[edges[k]] for k in (0, 1)]
    return float(np.percentile(np.concatenate(far), 99))


def test_who_stands_near_keeps_her_body_whatever_the_quality(outline):
    for best in (SOFTWARE, HARDWARE):
        whole = None
        for step in quality_steps(best):
            for near_count in (step.quality.near_count, 0):  # the fewest that there can be
                mask = outline(replace(step.quality, near_count=near_count), NEAR)
                whole = mask if whole is None else whole
                assert np.array_equal(mask, whole), step.name
        assert whole.sum() > 5000


@pytest.mark.parametrize("turns", [LUNGE, REACH], ids=["lunge", "reach"])
def test_where_the_level_changes_the_outline_stays(outline, turns):
    away = SOFTWARE.far_from
    near = outline(SOFTWARE, away, turns)
    far = outline(replace(SOFTWARE, near_level=DISTANT), away, turns)
    assert near.sum() > 500
    assert not np.array_equal(near, far)
    assert apart(near, far) <= ALLOWED


def test_a_crowd_changes_between_these_levels_alone(gl_context):
    for count in (50, 1000):
        quality = choose_quality(gl_context, count, None)
        assert quality.far_from >= 12.0
        assert (quality.near_level, quality.far_level) in ((LIGHT, DISTANT), (HARDWARE.near_level, HARDWARE.far_level))
