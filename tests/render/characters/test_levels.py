"""Levels of detail: near dancers keep the same body, and distant level changes are not visible."""

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
from tests.fixtures.mostly_long import mostly_long
from tests.render.poses import LUNGE, REACH, stage_view
from tests.render.test_renderer import scene

pytestmark = pytest.mark.gl
SIZE = (1280, 720)
NEAR = 3.0
"""Distance [m] at which a level change must not be visible."""
ALLOWED = 1.5
"""Maximum distance of the outlines at a level change [pixels], for 99 % of their points."""


@pytest.fixture
def outline(gl_context):
    """Mask (H, W) of the dancers, drawn at a quality from a distance [m]."""

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
        crowd.skin()
        surface.draw(crowd)
        mask = np.frombuffer(surface.depth.read(), np.float32).reshape(SIZE[::-1]) < 1.0
        for thing in (surface, crowd, frame):
            thing.release()
        return mask

    return seen


def outline_distance(a, b):
    """Distance between the outlines of two figures [pixels], 99th percentile over their points."""
    edges = [mask & ~ndimage.binary_erosion(mask) for mask in (a, b)]
    far = [ndimage.distance_transform_edt(~edges[1 - k])[edges[k]] for k in (0, 1)]
    return float(np.percentile(np.concatenate(far), 99))


@pytest.mark.long
def test_near_dancer_has_same_body_at_every_quality(outline):
    for best in (SOFTWARE, HARDWARE):
        whole = None
        for step in quality_steps(best):
            for near_count in (step.quality.near_count, 0):  # the fewest that there can be
                mask = outline(replace(step.quality, near_count=near_count), NEAR)
                whole = mask if whole is None else whole
                assert np.array_equal(mask, whole), step.name
        assert whole.sum() > 5000


@mostly_long("turns", [LUNGE, REACH], ids=["lunge", "reach"], quick=[1])
def test_outline_is_kept_at_level_change_distance(outline, turns):
    away = SOFTWARE.far_from
    near = outline(SOFTWARE, away, turns)
    far = outline(replace(SOFTWARE, near_level=DISTANT), away, turns)
    assert near.sum() > 500
    assert not np.array_equal(near, far)
    assert outline_distance(near, far) <= ALLOWED


def test_crowd_uses_only_tested_levels(gl_context):
    for count in (50, 1000):
        quality = choose_quality(gl_context, count)
        assert quality.far_from >= 12.0
        assert (quality.near_level, quality.far_level) in ((LIGHT, DISTANT), (HARDWARE.near_level, HARDWARE.far_level))
