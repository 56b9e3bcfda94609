"""Failing passes are disabled while the picture continues, until an operator resets them."""

from typing import Any

import moderngl
import pytest

from live.render.adaptive_quality import HARDWARE
from live.render.passes.background_pass import BackgroundPass
from live.render.passes.bloom_pass import BloomPass
from live.render.passes.floor_pass import ReflectionPass
from live.render.passes.overlay_pass import OverlayPass
from live.render.renderer import Renderer
from live.render.uniforms import FrameUniforms
from tests.fixtures.mostly_long import mostly_long
from tests.render.poses import ARMS_DOWN, stage_view
from tests.render.test_renderer import read, scene

pytestmark = pytest.mark.gl
SIZE = (96, 64)


@mostly_long(
    ("kind", "method", "name"),
    [
        (BloomPass, "compute_glow", "bloom"),
        (ReflectionPass, "draw", "mirror"),
        (OverlayPass, "draw", "overlay"),
        (BackgroundPass, "prepare", "background"),
    ],
    quick=[1],
)
def test_failing_pass_is_disabled_after_two_frames_until_reset(
    gl_context: moderngl.Context, monkeypatch: pytest.MonkeyPatch, kind: type, method: str, name: str
) -> None:
    renderer = Renderer(gl_context, scene(1), size=SIZE, quality=HARDWARE)
    target = gl_context.simple_framebuffer(SIZE)
    view = stage_view([(ARMS_DOWN, (0.0, 0.0), 0.0, 0)])
    view.overlay = ("overlay",)
    usual, fails, calls = getattr(kind, method), [True], [0]

    def broken(*arguments: Any, **options: Any) -> Any:
        if options.get("visible") is not False and type(arguments[0]) is kind:
            calls[0] += 1
            if fails[0]:
                raise RuntimeError("the driver does not like it")
        return usual(*arguments, **options)

    monkeypatch.setattr(kind, method, broken)
    monkeypatch.setattr(FrameUniforms, "mirrors", True)
    if kind in (BackgroundPass, BloomPass):
        monkeypatch.setattr(kind, "active", lambda self, moment: True)
    for _ in range(2):
        with pytest.raises(RuntimeError):
            renderer.draw(view, target)
    for _ in range(3):
        renderer.draw(view, target)
    assert calls[0] == 2
    assert read(target).max() > 50
    assert len(renderer.problems) == 1
    assert renderer.problems[0].startswith(f"pass {name} is left out (RuntimeError: the driver does not like it)")
    fails[0] = False
    renderer.reset_pass(f"pass {name}")
    renderer.draw(view, target)
    assert (calls[0], renderer.problems) == (3, [])
    renderer.release()
    target.release()
