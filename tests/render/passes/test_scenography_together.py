"""Everything of the scenography in one picture: sizes, quality steps, new shaders, and no error of OpenGL."""

from dataclasses import replace

import numpy as np
import pytest

from live.base.picture_parameters import BY_ADDRESS, picture_row
from live.base.stage_snapshot import Background, SceneryFile, Title
from live.render.adaptive_quality import HARDWARE, SOFTWARE
from live.render.renderer import Renderer
from tests.render.media import lathe, write_glb, write_image, write_sequence
from tests.render.test_renderer import crowd, read, scene

pytestmark = [pytest.mark.gl, pytest.mark.long]
ON = {"background/1": 1.0, "background/2": 1.0, "background/3": 0.7, "scenery/1": 1.0} | {
    "pass/focus": 1.0,
    "pass/blur": 0.5,
}


@pytest.mark.parametrize("quality", [SOFTWARE, HARDWARE], ids=["software", "card"])
def test_all_of_it_survives_sizes_steps_and_new_shaders(gl_context, tmp_path, quality):
    of = replace(
        scene(12),
        backgrounds=(
            Background(str(write_image(tmp_path / "a.png"))),
            Background(str(write_sequence(tmp_path / "s") / "pic_###.png"), place="floor", width=5.0, end="hold"),
            Background(str(tmp_path / "a.png"), place="front", blend="add"),
        ),
        scenery=(
            SceneryFile(str(write_glb(tmp_path / "p.glb", [lathe([(0.3, 0), (0.3, 2), (0.001, 2)])])), (3.0, 0.0)),
        ),
    )
    renderer = Renderer(gl_context, of, size=(160, 90), quality=quality, steps=True, blocking_video=True)
    target = {size: gl_context.framebuffer([gl_context.texture(size, 4)]) for size in ((160, 90), (96, 128), (1, 1))}
    _ = gl_context.error
    pictures = {}

    def draw(size, number):
        view = crowd()
        view.joint_position[..., 0] += 0.05 * number
        view.time, view.beat = 0.04 * number, 0.08 * number
        view.picture = picture_row(of)
        view.titles = (
            Title("A|B", size=0.2),
            Title("SEA", "stage", (0.0, 2.0, -3.0), 1.0, entrance="wipe", progress=0.5),
        )
        for name, value in ON.items():
            view.picture[BY_ADDRESS[f"/dance/{name}"].first] = value
        renderer.draw(view, target[size])
        assert gl_context.error == "GL_NO_ERROR"
        return read(target[size])

    for number, size in enumerate(((160, 90), (160, 90), (96, 128), (1, 1), (160, 90))):
        renderer.resize(size)
        pictures[number] = draw(size, number)
    assert np.abs(pictures[4].astype(int) - pictures[1]).mean() < 12.0  # as before
    for step in range(len(renderer.steps)):
        renderer.set_step(step)
        assert draw((160, 90), 6 + step).max() > 60
    renderer.set_step(0)
    renderer.reload_shaders()
    assert np.abs(draw((160, 90), 60).astype(int) - pictures[4]).mean() < 12.0
    assert renderer.problems == []
    renderer.release()
    for each in target.values():
        each.release()
