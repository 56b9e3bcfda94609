"""Golden pictures of test cards and warped outputs, each with a condition that an empty picture breaks."""

import numpy as np
import pytest
from PIL import Image

from live.render.headless import OffscreenTarget
from live.render.outputs.output import Output, SoftEdge
from live.render.outputs.output_pass import HandlePass
from live.render.outputs.warp import regular_mesh
from live.render.outputs.warp_editor import WarpEditor
from tests.render.outputs.conftest import SIZE

WIDTH, HEIGHT = SIZE


def chequered_ramp():
    """A picture whose colours encode position: a colour ramp with a chequer of 16 pixels."""
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    chequer = 0.55 + 0.45 * ((x // 16 + y // 16) % 2)
    picture = np.stack([x / WIDTH, y / HEIGHT, 1.0 - x / WIDTH], axis=2) * chequer[..., None]
    return (picture * 255.0).round().astype(np.uint8)


def bright_share(seen, over=120):
    return float((seen.max(axis=2) > over).mean())


LAWS = {
    "grid": lambda seen: 0.03 < bright_share(seen) < 0.3 and seen[0, 40, 0] > 200 and seen[90, 100].max() > 200,
    "bars": lambda seen: len(np.unique(seen[30, 10::45], axis=0)) == 7 and seen[30, 5, 1] == 191,
    "name": lambda seen: 0.02 < bright_share(seen) < 0.3 and seen[60:120, 110:210].max() == 255,
    "safe": lambda seen: bright_share(seen, 100) > 0.01 and seen[90, 160].max() > 150 and seen[4, 4].max() < 60,
    "focus": lambda seen: 0.1 < bright_share(seen) < 0.5 and seen[60:120, 130:190].std() > 80,
}
MESH = (
    ((0.0, 0.06), (0.5, -0.02), (1.0, 0.06)),
    ((0.02, 0.5), (0.47, 0.55), (0.98, 0.5)),
    ((0.0, 0.94), (0.5, 1.03), (1.0, 0.94)),
)
BENT = {
    "corner_pin": Output(corners=((0.1, 0.12), (0.93, 0.04), (0.86, 0.95), (0.05, 0.85))),
    "mesh": Output(corners=((0.04, 0.04), (0.96, 0.04), (0.96, 0.96), (0.04, 0.96)), mesh=MESH),
    "turned": Output(rotation=90, mirror=True),
    "soft_edge": Output(crop=(0.0, 0.0, 0.6, 1.0), edge=SoftEdge(right=0.4, bottom=0.2, black=0.01)),
}


@pytest.mark.parametrize("card", list(LAWS))
def test_golden_cards(golden, throw, card):
    golden(throw(chequered_ramp(), Output("left"), card=card, number=1), f"card_{card}", law=LAWS[card])


@pytest.mark.parametrize("name", list(BENT))
def test_golden_warped_outputs(golden, throw, name):
    seen = throw(chequered_ramp(), BENT[name])
    straight = chequered_ramp().astype(int)
    golden(
        seen,
        f"output_{name}",
        law=lambda picture: np.abs(picture - straight).mean() > 8 and bright_share(picture) > 0.3,
    )


def test_golden_mask_with_lower_brightness(golden, throw, tmp_path):
    mask = np.zeros((90, 160), np.uint8)
    mask[20:70, 30:140] = 255
    mask[20:70, 100:140] = np.linspace(255, 0, 40).astype(np.uint8)
    Image.fromarray(mask).save(tmp_path / "mask.png")
    seen = throw(chequered_ramp(), Output(mask=tmp_path / "mask.png", brightness=0.7, gamma=1.4))

    def law(picture):
        inside = picture[60:100, 70:190].max()
        dark = not picture[:30].any() and not picture[:, :50].any()
        return dark and 60 < inside < 0.8 * chequered_ramp()[60:100, 70:190].max()

    golden(seen, "output_mask", law=law)


def test_golden_editing_handles_with_help(golden, gl_context):
    target = OffscreenTarget(gl_context, SIZE)
    handles, editing = HandlePass(gl_context, SIZE[1]), WarpEditor(BENT["corner_pin"])
    editing.toggle_mesh()
    editing.next(4)
    target.framebuffer.use()
    target.framebuffer.clear(0.1, 0.1, 0.1, 1.0)
    handles.draw(editing.points, editing.chosen, ("left: point 5 of 9", "Enter keep"), target.framebuffer)
    middle = [round(share * side) for share, side in zip(editing.points[4], SIZE, strict=True)]

    def law(picture):
        x, y = middle
        return picture[y - 6 : y + 7, x - 6 : x + 7].max() > 150 and bright_share(picture) > 0.005

    golden(target.read().copy(), "output_handles", law=law)
    for thing in (handles, target):
        thing.release()


def test_golden_grid_card_through_mesh(golden, throw):
    seen = throw(
        chequered_ramp(),
        Output("left", mesh=(regular_mesh(3, 2)[0], ((0.0, 1.0), (0.5, 0.9), (1.0, 1.0)))),
        card="grid",
    )
    golden(
        seen, "card_grid_mesh", law=lambda picture: not picture[175:, 140:180].any() and bright_share(picture) > 0.02
    )
