"""Textures that the worlds share: noise for haze, clouds, waves and paper, and the gobos of the key light.

Both are made here from a seed, tile without seams, and are bound for all programs at `shader.SHARED_TEXTURES`.
"""

from functools import cache
from typing import Final

import moderngl
import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw, ImageFilter

from live.base.arrays import Float64
from live.render.shader import SHARED_TEXTURES, release_all

NOISE_SIZE: Final = 512
GOBO_SIZE: Final = 256
_SEED: Final = 31
_FIBRES: Final = 900
_LEAVES: Final = 230
Bytes = npt.NDArray[np.uint8]


@cache
def noise_texels() -> Bytes:
    """Return two soft noises, paper's grain and paper's fibres, 0 to 255, shape (512, 512, 4): each tiles."""
    draw = np.random.default_rng(_SEED)
    soft = _even(_spectral_noise(draw, 1.9, 2.5))
    other = _even(_spectral_noise(draw, 1.6, 4.0))
    grain = _even(_spectral_noise(draw, 0.55, 30.0))
    layers = np.stack([soft, other, grain, _fibres(draw)], axis=-1)
    return np.ascontiguousarray(np.rint(layers * 255.0), np.uint8)


def _spectral_noise(draw: np.random.Generator, power: float, lowest: float) -> Float64:
    """Return noise whose amplitudes fall with frequency to that power, from `lowest` periods on."""
    side = np.fft.fftfreq(NOISE_SIZE) * NOISE_SIZE
    frequency = np.hypot(side[:, None], side[None, :])
    strength = np.where(frequency > 0.0, 1.0 / (lowest**2 + frequency**2) ** (0.5 * power), 0.0)
    return np.asarray(np.fft.ifft2(np.fft.fft2(draw.standard_normal((NOISE_SIZE, NOISE_SIZE))) * strength).real)


def _even(noise: Float64) -> Float64:
    """Return noise whose values are nearly evenly spread from 0 to 1."""
    level = (noise - noise.mean()) / noise.std()
    return np.asarray(np.clip(0.5 + 0.5 * np.tanh(0.85 * level), 0.0, 1.0))


def _fibres(draw: np.random.Generator) -> Float64:
    """Return fibres in paper: short bent strokes, some lighter and some darker than 0.5."""
    sheet = np.zeros((NOISE_SIZE, NOISE_SIZE))
    steps = 70
    heading = draw.uniform(0.0, 2.0 * np.pi, (_FIBRES, 1)) + np.cumsum(draw.normal(0.0, 0.09, (_FIBRES, steps)), axis=1)
    place = draw.uniform(0.0, NOISE_SIZE, (_FIBRES, 1, 2))
    place = place + 0.8 * np.cumsum(np.stack([np.cos(heading), np.sin(heading)], axis=-1), axis=1)
    shade = draw.normal(0.0, 1.0, (_FIBRES, 1)) * np.sin(np.linspace(0.0, np.pi, steps))
    rows, columns = (np.rint(place[..., axis]).astype(np.intp) % NOISE_SIZE for axis in (1, 0))
    np.add.at(sheet, (rows, columns), shade)
    for axis in (0, 1):  # a pen as wide as two texels
        sheet = 0.5 * sheet + 0.25 * (np.roll(sheet, 1, axis) + np.roll(sheet, -1, axis))
    return np.asarray(np.clip(0.5 + 0.28 * sheet, 0.0, 1.0))


@cache
def gobo_texels() -> Bytes:
    """Return how much light each gobo lets through, 0 to 255, shape (256, 256, 4): leaves, window, blinds, breakup."""
    draw = np.random.default_rng(_SEED + 1)
    soft = noise_texels()[::2, ::2, 0] / 255.0
    layers = [
        _blurred(_leaves(draw), 1.6),
        _blurred(_window(), 2.2),
        _blurred(_blinds(), 1.8),
        _blurred(Image.fromarray(np.rint(np.clip((soft - 0.46) * 6.0 + 0.5, 0.07, 1.0) * 255.0).astype(np.uint8)), 3.0),
    ]
    return np.ascontiguousarray(np.rint(np.stack(layers, axis=-1) * 255.0), np.uint8)


def _leaves(draw: np.random.Generator) -> Image.Image:
    """Return gaps of light between leaves, as of a crown of a tree above."""
    image = Image.new("L", (GOBO_SIZE, GOBO_SIZE), 255)
    pen = ImageDraw.Draw(image)
    along = np.linspace(0.0, 1.0, 9)
    for _ in range(_LEAVES):
        x, y, angle = draw.uniform(0.0, GOBO_SIZE), draw.uniform(0.0, GOBO_SIZE), draw.uniform(0.0, 2.0 * np.pi)
        length, shade = draw.uniform(16.0, 44.0), int(draw.uniform(0.0, 70.0))
        half = 0.20 * length * np.sin(np.pi * along**0.8)
        outline = np.concatenate([np.stack([along * length, half], 1), np.stack([along * length, -half], 1)[::-1]])
        turned = outline @ np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        for over_x in (-GOBO_SIZE, 0, GOBO_SIZE):
            for over_y in (-GOBO_SIZE, 0, GOBO_SIZE):
                points = [(float(px + x + over_x), float(py + y + over_y)) for px, py in turned]
                pen.polygon(points, fill=shade)
    return image


def _window() -> Image.Image:
    """Return two by three panes of a window in a dark wall."""
    image = Image.new("L", (GOBO_SIZE, GOBO_SIZE), 10)
    pen = ImageDraw.Draw(image)
    for column in range(2):
        for row in range(3):
            left, top = 50 + 82 * column, 22 + 73 * row
            pen.rectangle((left, top, left + 72, top + 63), fill=255)
    return image


def _blinds() -> Image.Image:
    image = Image.new("L", (GOBO_SIZE, GOBO_SIZE), 18)
    pen = ImageDraw.Draw(image)
    for slat in range(8):
        pen.rectangle((0, 32 * slat + 6, GOBO_SIZE, 32 * slat + 23), fill=255)
    return image


def _blurred(image: Image.Image, radius: float) -> Float64:
    """Return an image that tiles, softened without a seam, 0 to 1."""
    tiles = Image.new("L", (3 * GOBO_SIZE, 3 * GOBO_SIZE))
    for column in range(3):
        for row in range(3):
            tiles.paste(image, (column * GOBO_SIZE, row * GOBO_SIZE))
    soft = np.asarray(tiles.filter(ImageFilter.GaussianBlur(radius)), np.float64)
    return soft[GOBO_SIZE : 2 * GOBO_SIZE, GOBO_SIZE : 2 * GOBO_SIZE] / 255.0


class WorldTextures:
    """The shared textures of one context."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._noise, self._gobos = (_texture(ctx, texels) for texels in (noise_texels(), gobo_texels()))

    def bind(self) -> None:
        """Bind them for all programs."""
        self._noise.use(SHARED_TEXTURES["noise_map"])
        self._gobos.use(SHARED_TEXTURES["gobo_map"])

    def release(self) -> None:
        """Free them."""
        release_all(self._noise, self._gobos)


def _texture(ctx: moderngl.Context, texels: Bytes) -> moderngl.Texture:
    texture = ctx.texture((texels.shape[1], texels.shape[0]), 4, texels.tobytes())
    texture.build_mipmaps()
    texture.filter = (moderngl.LINEAR_MIPMAP_NEAREST, moderngl.LINEAR)
    return texture
