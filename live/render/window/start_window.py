"""Window that shows how far a first start is, before the show's own windows open."""

from typing import Final

import moderngl
import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw, ImageFont

from live.render.lettering.glyph_atlas import without_accents
from live.render.window.monitors import Monitor
from live.render.window.window import Window
from live.render.window.window_input import CloseRequested, KeyPressed

VERTEX_SHADER: Final = """#version 410
out vec2 place;
void main() {
    place = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    gl_Position = vec4(place * 2.0 - 1.0, 0.0, 1.0);
    place.y = 1.0 - place.y;
}
"""
FRAGMENT_SHADER: Final = """#version 410
uniform sampler2D picture;
in vec2 place;
out vec4 colour;
void main() { colour = vec4(texture(picture, place).rrr, 1.0); }
"""
BRIGHT: Final = 220
DIM: Final = 110
DARK: Final = 45
LEFT: Final = 0.12
"""Left edge of words and bar, as a share of the width; the bar ends as far from the right."""


class StartWindow:
    """Black, with a title, a line and a bar. Thread: main thread only."""

    def __init__(self, title: str, *, monitor: Monitor | None, fullscreen: bool, size: tuple[int, int]) -> None:
        """Raise `NoWindow` or `UnknownMonitor` as `Window` does. `size`: of a window that is not full screen."""
        self._title = title
        self._window = Window(title, monitor=monitor, fullscreen=fullscreen, size=size)
        ctx = self._window.ctx
        self._program = ctx.program(vertex_shader=VERTEX_SHADER, fragment_shader=FRAGMENT_SHADER)
        self._quad = ctx.vertex_array(self._program, [])

    def show(self, line: str, share: float) -> bool:
        """Draw; return False once the window was closed or Esc pressed. `share`: of the work that is done, 0 to 1."""
        picture = start_picture(self._window.size, self._title, line, share)
        ctx = self._window.ctx
        texture = ctx.texture((picture.shape[1], picture.shape[0]), 1, picture.tobytes(), alignment=1)
        self._window.target.use()
        texture.use(0)
        self._quad.render(moderngl.TRIANGLE_STRIP, vertices=4)
        self._window.swap()
        texture.release()
        inputs = self._window.poll()
        return not any(isinstance(each, CloseRequested) or _is_escape(each) for each in inputs)

    def close(self) -> None:
        """Close the window."""
        self._window.close()


def _is_escape(each: object) -> bool:
    return isinstance(each, KeyPressed) and each.name == "escape"


def start_picture(size: tuple[int, int], title: str, line: str, share: float) -> npt.NDArray[np.uint8]:
    """Return the picture, grey values (H, W), top row first."""
    width, height = max(size[0], 16), max(size[1], 16)
    image = Image.new("L", (width, height))
    draw = ImageDraw.Draw(image)
    left, right, middle = width * LEFT, width * (1.0 - LEFT), height * 0.5
    for words, top, tall, grey in ((title, -0.12, 0.07, BRIGHT), (line, 0.06, 0.032, DIM)):
        font = ImageFont.load_default(size=max(8.0, height * tall))
        draw.text((left, middle + height * top), without_accents(words), fill=grey, font=font)
    bar = (middle, middle + max(2.0, height * 0.008))
    draw.rectangle((left, bar[0], right, bar[1]), fill=DARK)
    draw.rectangle((left, bar[0], left + (right - left) * min(max(share, 0.0), 1.0), bar[1]), fill=BRIGHT)
    return np.asarray(image)
