"""Pictures with alpha: laid over anything they look as if they had been drawn there."""

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
from tests.render.passes.test_passes import SCENE, three

pytestmark = pytest.mark.gl
SIZE = (256, 144)


@pytest.fixture(scope="module")
def made(headless_context: moderngl.Context) -> Iterator[tuple[Renderer, OffscreenTarget]]:
    """One renderer of pictures with alpha."""
    with headless_context:
        yield (
            Renderer(headless_context, SCENE, size=SIZE, transparent=True),
            OffscreenTarget(headless_context, SIZE, alpha=True),
        )


@pytest.fixture
def bare(made: tuple[Renderer, OffscreenTarget], gl_context: moderngl.Context) -> tuple[Renderer, OffscreenTarget]:
    """It, while its context is current."""
    return made


def drawn(
    bare: tuple[Renderer, OffscreenTarget], *, brightness: float = 1.0, key: float = 1.0, **said: float
) -> np.ndarray:
    """The three dancers on nothing, RGBA 0 to 1."""
    renderer, target = bare
    view = three()
    view.picture = picture_row(SCENE)
    view.brightness = brightness
    view.picture[BY_ADDRESS["/dance/light/key"].row_slice] = key
    for name, value in said.items():
        view.picture[BY_ADDRESS["/dance/pass/" + name].row_slice] = value
    for _ in range(2):
        renderer.draw(view, target.framebuffer)
    return target.read() / 255.0


def over(picture: np.ndarray, ground: float) -> np.ndarray:
    """Laid over a grey."""
    return picture[..., :3] * picture[..., 3:] + ground * (1.0 - picture[..., 3:])


def test_a_picture_on_nothing(bare: tuple[Renderer, OffscreenTarget], golden) -> None:
    picture = drawn(bare)
    assert not picture[:20].any()
    assert not picture[..., 3][:, :20].any()
    alpha = picture[..., 3]
    assert 0.03 < (alpha == 1.0).mean() < 0.3
    shown = np.round(over(picture, 0.5) * 255.0).astype(np.uint8)
    golden(shown, "bare", law=lambda seen: 0.03 < (np.abs(seen.astype(int) - 128).max(axis=2) > 20).mean() < 0.3)


def test_edges_are_of_the_colour_of_what_they_are_edges_of(bare: tuple[Renderer, OffscreenTarget]) -> None:
    """Straight alpha: half covered pixels are as bright as whole ones beside them, so there is no dark seam."""
    picture = drawn(bare, bloom=0.0)
    alpha, grey = picture[..., 3], picture[..., :3].mean(axis=2)
    edge = (alpha > 0.2) & (alpha < 0.8)
    assert edge.sum() > 100
    whole = np.where(alpha == 1.0, grey, np.nan)
    padded = np.pad(whole, 1, constant_values=np.nan)
    around = np.stack([padded[1 + y : 145 + y, 1 + x : 257 + x] for y in (-1, 0, 1) for x in (-1, 0, 1)])
    near = edge & (~np.isnan(around)).any(axis=0)
    beside = np.nanmean(around[:, near], axis=0)
    assert grey[near].mean() > 0.85 * beside.mean()  # premultiplied it would be half of it


def test_cover_is_between_and_light_covers_nothing(bare: tuple[Renderer, OffscreenTarget]) -> None:
    without, with_glow = drawn(bare, key=4.0, bloom=0.0), drawn(bare, key=4.0, bloom=4.0)
    bodies = without[..., 3] > 0.0
    assert np.array_equal(with_glow[..., 3][bodies], without[..., 3][bodies])
    glow = with_glow[..., 3][~bodies]
    assert glow.max() > 0.05
    assert with_glow[..., :3][~bodies][glow > 0.05].max(axis=1).min() > 0.9, "over black it is exactly as bright"


def test_a_blackout_leaves_nothing(bare: tuple[Renderer, OffscreenTarget]) -> None:
    full, half = drawn(bare), drawn(bare, brightness=0.5)
    whole = full[..., 3] == 1.0
    assert np.abs(half[..., 3][whole] - 0.5).max() < 0.01
    assert not drawn(bare, brightness=0.0).any()


def test_what_is_behind_the_dancers_is_not_there(gl_context: moderngl.Context, tmp_path: Path) -> None:
    Image.new("RGB", (64, 36), (250, 180, 90)).save(tmp_path / "sky.png")
    scene = replace(SCENE, backgrounds=(Background(str(tmp_path / "sky.png"), fit="picture"),))
    view = three()
    view.picture = picture_row(scene)
    view.picture[BY_ADDRESS["/dance/background/1"].row_slice] = 1.0
    alpha = []
    for bare in (False, True):
        renderer = Renderer(gl_context, scene, size=SIZE, transparent=bare, quality=HARDWARE)
        target = OffscreenTarget(gl_context, SIZE, alpha=True)
        renderer.draw(view, target.framebuffer)
        alpha.append(target.read()[:12].copy())
        renderer.release()
        target.release()
    assert alpha[0][..., :3].max() > 100, "with a stage it is seen"
    assert not alpha[1].any()


def test_another_size(bare: tuple[Renderer, OffscreenTarget], headless_context: moderngl.Context) -> None:
    renderer, _ = bare
    small = OffscreenTarget(headless_context, (128, 72), alpha=True)
    renderer.resize((128, 72))
    renderer.draw(three(), small.framebuffer)
    there = small.read()[..., 3] / 255.0
    renderer.resize(SIZE)
    whole = drawn(bare)[..., 3]
    assert there.mean() == pytest.approx(whole.mean(), rel=0.05)
    small.release()
