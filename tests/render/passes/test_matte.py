"""Pictures with alpha: composited over a background, edges and light look as if drawn there."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import moderngl
import numpy as np
import pytest
from PIL import Image

from live.base.picture_parameters import BY_ADDRESS, picture_row
from live.base.stage_snapshot import Background
from live.render.adaptive_quality import HARDWARE
from live.render.headless import OffscreenTarget
from live.render.renderer import Renderer
from tests.render.passes.test_passes import SCENE, three_dancers

pytestmark = pytest.mark.gl
SIZE = (256, 144)


@pytest.fixture(scope="module")
def alpha_renderer(headless_context: moderngl.Context) -> Iterator[tuple[Renderer, OffscreenTarget]]:
    """One renderer of pictures with alpha, and its target."""
    with headless_context:
        yield (
            Renderer(headless_context, SCENE, size=SIZE, transparent=True),
            OffscreenTarget(headless_context, SIZE, alpha=True),
        )


@pytest.fixture
def current_renderer(
    alpha_renderer: tuple[Renderer, OffscreenTarget], gl_context: moderngl.Context
) -> tuple[Renderer, OffscreenTarget]:
    """The renderer and its target, with the OpenGL context current."""
    return alpha_renderer


def draw_dancers(
    current_renderer: tuple[Renderer, OffscreenTarget], *, brightness: float = 1.0, key: float = 1.0, **said: float
) -> np.ndarray:
    """The three dancers on a transparent background, RGBA from 0 to 1."""
    renderer, target = current_renderer
    view = three_dancers()
    view.picture = picture_row(SCENE)
    view.brightness = brightness
    view.picture[BY_ADDRESS["/dance/light/key"].row_slice] = key
    for name, value in said.items():
        view.picture[BY_ADDRESS["/dance/pass/" + name].row_slice] = value
    for _ in range(2):
        renderer.draw(view, target.framebuffer)
    return target.read() / 255.0


def composite(picture: np.ndarray, ground: float) -> np.ndarray:
    """The picture composited over a grey."""
    return picture[..., :3] * picture[..., 3:] + ground * (1.0 - picture[..., 3:])


@pytest.mark.long
def test_golden_picture_on_transparent_background(current_renderer: tuple[Renderer, OffscreenTarget], golden) -> None:
    picture = draw_dancers(current_renderer)
    assert not picture[:20].any()
    assert not picture[..., 3][:, :20].any()
    alpha = picture[..., 3]
    assert 0.03 < (alpha == 1.0).mean() < 0.3
    shown = np.round(composite(picture, 0.5) * 255.0).astype(np.uint8)
    golden(shown, "bare", law=lambda seen: 0.03 < (np.abs(seen.astype(int) - 128).max(axis=2) > 20).mean() < 0.3)


def test_edge_pixels_have_straight_alpha_colour(current_renderer: tuple[Renderer, OffscreenTarget]) -> None:
    """Straight alpha: half-covered pixels are as bright as full ones next to them, so there is no dark seam."""
    picture = draw_dancers(current_renderer, bloom=0.0)
    alpha, grey = picture[..., 3], picture[..., :3].mean(axis=2)
    edge = (alpha > 0.2) & (alpha < 0.8)
    assert edge.sum() > 100
    whole = np.where(alpha == 1.0, grey, np.nan)
    padded = np.pad(whole, 1, constant_values=np.nan)
    around = np.stack([padded[1 + y : 145 + y, 1 + x : 257 + x] for y in (-1, 0, 1) for x in (-1, 0, 1)])
    near = edge & (~np.isnan(around)).any(axis=0)
    beside = np.nanmean(around[:, near], axis=0)
    assert grey[near].mean() > 0.85 * beside.mean()  # premultiplied it would be half of it


def test_glow_adds_alpha_only_outside_bodies(current_renderer: tuple[Renderer, OffscreenTarget]) -> None:
    without, with_glow = (
        draw_dancers(current_renderer, key=4.0, bloom=0.0),
        draw_dancers(current_renderer, key=4.0, bloom=4.0),
    )
    bodies = without[..., 3] > 0.0
    assert np.array_equal(with_glow[..., 3][bodies], without[..., 3][bodies])
    glow = with_glow[..., 3][~bodies]
    assert glow.max() > 0.05
    assert with_glow[..., :3][~bodies][glow > 0.05].max(axis=1).min() > 0.9, "over black it is exactly as bright"


def test_blackout_is_fully_transparent(current_renderer: tuple[Renderer, OffscreenTarget]) -> None:
    full, half = draw_dancers(current_renderer), draw_dancers(current_renderer, brightness=0.5)
    whole = full[..., 3] == 1.0
    assert np.abs(half[..., 3][whole] - 0.5).max() < 0.01
    assert not draw_dancers(current_renderer, brightness=0.0).any()


@pytest.mark.long
def test_background_is_omitted_from_transparent_picture(gl_context: moderngl.Context, tmp_path: Path) -> None:
    Image.new("RGB", (64, 36), (250, 180, 90)).save(tmp_path / "sky.png")
    scene = replace(SCENE, backgrounds=(Background(str(tmp_path / "sky.png"), fit="picture"),))
    view = three_dancers()
    view.picture = picture_row(scene)
    view.picture[BY_ADDRESS["/dance/background/1"].row_slice] = 1.0
    alpha = []
    for transparent in (False, True):
        renderer = Renderer(gl_context, scene, size=SIZE, transparent=transparent, quality=HARDWARE)
        target = OffscreenTarget(gl_context, SIZE, alpha=True)
        renderer.draw(view, target.framebuffer)
        alpha.append(target.read()[:12].copy())
        renderer.release()
        target.release()
    assert alpha[0][..., :3].max() > 100, "with a stage it is seen"
    assert not alpha[1].any()


def test_resized_picture_keeps_coverage(
    current_renderer: tuple[Renderer, OffscreenTarget], headless_context: moderngl.Context
) -> None:
    renderer, _ = current_renderer
    small = OffscreenTarget(headless_context, (128, 72), alpha=True)
    renderer.resize((128, 72))
    renderer.draw(three_dancers(), small.framebuffer)
    there = small.read()[..., 3] / 255.0
    renderer.resize(SIZE)
    whole = draw_dancers(current_renderer)[..., 3]
    assert there.mean() == pytest.approx(whole.mean(), rel=0.05)
    small.release()
