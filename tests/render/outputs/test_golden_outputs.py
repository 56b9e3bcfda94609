"""Test cards and bent pictures as they look: small, on llvmpipe, each with a law that an empty one breaks."""

import numpy as np
import pytest

from live.render.outputs.mesh import regular
from live.render.outputs.output import Output, SoftEdge
from tests.render.outputs.conftest import SIZE

WIDTH, HEIGHT = SIZE


def stage():
    """A picture that tells where it was bent: a ramp of colours with a fine chequer of 16 pixels."""
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    chequer = 0.55 + 0.45 * ((x // 16 + y // 16) % 2)
    picture = np.stack([x / WIDTH, y / HEIGHT, 1.0 - x / WIDTH], axis=2) * chequer[..., None]
    return (picture * 255.0).round().astype(np.uint8)


def bright(seen, over=120):
    return float((seen.max(axis=2) > over).mean())


LAWS = {
    "grid": lambda seen: 0.03 < bright(seen) < 0.3 and seen[0, 40, 0] > 200 and seen[90, 100].max() > 200,
    "bars": lambda seen: len(np.unique(seen[30, 10::45], axis=0)) == 7 and seen[30, 5, 1] == 191,
    "name": lambda seen: 0.02 < bright(seen) < 0.3 and seen[60:120, 110:210].max() == 255,
    "safe": lambda seen: bright(seen, 100) > 0.01 and seen[90, 160].max() > 150 and seen[4, 4].max() < 60,
    "focus": lambda seen: 0.1 < bright(seen) < 0.5 and seen[60:120, 130:190].std() > 80,
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
def test_cards(golden, throw, card):
    golden(throw(stage(), Output("left"), card=card, number=1), f"card_{card}", law=LAWS[card])


@pytest.mark.parametrize("name", list(BENT))
def test_bent(golden, throw, name):
    seen = throw(stage(), BENT[name])
    straight = stage().astype(int)
    golden(seen, f"output_{name}", law=lambda picture: np.abs(picture - straight).mean() > 8 and bright(picture) > 0.3)


def test_a_grid_through_a_mesh(golden, throw):
    seen = throw(stage(), Output("left", mesh=(regular(3, 2)[0], ((0.0, 1.0), (0.5, 0.9), (1.0, 1.0)))), card="grid")
    golden(seen, "card_grid_mesh", law=lambda picture: not picture[175:, 140:180].any() and bright(picture) > 0.02)
