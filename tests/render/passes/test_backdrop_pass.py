"""Tests of the kept backdrop: small while light or camera move, whole once they have stopped."""

import pytest

from live.base.stage_snapshot import Camera, Scene
from live.motion.skeleton import JOINT_COUNT
from live.render.passes.stage_pass import BackdropPass
from live.render.uniforms import FrameUniforms

SIZE, SMALL = (64, 36), (32, 18)


@pytest.fixture
def backdrop(gl_context):
    frame = FrameUniforms(gl_context, Scene((8.0, 6.0), Camera(), 1, JOINT_COUNT), SIZE)
    made = BackdropPass(gl_context, SIZE, coarse=True)
    yield made
    made.release()
    frame.release()


def sizes(backdrop: BackdropPass, changes: list[bool]) -> list[tuple[int, int]]:
    """The backdrop's size after each frame; `changes`: whether light or camera have changed in it."""
    seen = []
    for moving in changes:
        if moving:
            backdrop.invalidate()
        backdrop.draw({"haze": 1.0}, moving=moving)
        seen.append(backdrop.texture.size)
    return seen


def test_it_is_whole_at_once_after_a_single_change(backdrop):
    assert sizes(backdrop, [True, False, False]) == [SMALL, SIZE, SIZE]


def test_it_stays_small_while_light_changes_again_and_again(backdrop):
    assert set(sizes(backdrop, [True, False] + 20 * [True, False, False])[2:]) == {SMALL}
    after = sizes(backdrop, 60 * [False])
    assert after[-1] == SIZE
    assert after == sorted(after)  # it does not become small again


def test_it_is_drawn_anew_only_after_a_change(backdrop):
    sizes(backdrop, [True, False])
    mark = b"\x3c" * (SIZE[0] * SIZE[1] * 8)
    backdrop.texture.write(mark)
    sizes(backdrop, 60 * [False])
    assert backdrop.texture.read() == mark
    sizes(backdrop, [True, False])
    assert backdrop.texture.read() != mark
