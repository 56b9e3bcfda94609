"""Golden pictures: small, seeded, drawn on llvmpipe; compared with a tolerance and a condition (law) each.

    def test_it(golden, draw):  # `golden` is a fixture of this package: it skips on any other driver
        golden(draw(view), "ink", law=lambda seen: (seen < 40).mean() > 0.01)

`pytest tests/render --regenerate-goldens` rewrites them: look at each, then commit it. A picture that breaks its
law is never written.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

Picture = npt.NDArray[np.uint8]
Law = Callable[[Picture], bool]

FOLDER: Final = Path(__file__).parent / "golden"
KINDS: Final = ("camera", "card", "light", "output", "pass", "style")
"""First words of names whose pictures are kept in a separate folder."""
LARGEST: Final = 48_000
"""Maximum size of a golden picture [bytes]."""
OFF: Final = 12
"""A pixel is off if one of its colours differs by more steps of 255 than this."""


def describe_difference(picture: Picture, expected: Picture, *, mean: float, off: float) -> str:
    """How two pictures (H, W, 3) differ beyond the tolerance, in words; empty if they do not."""
    if picture.shape != expected.shape:
        return f"it is {picture.shape}, not {expected.shape}"
    difference = np.abs(picture.astype(np.int16) - expected.astype(np.int16))
    share = float((difference.max(axis=2) > OFF).mean())
    if difference.mean() > mean or share > off:
        return f"{difference.mean():.2f} steps off on average ({mean}), {share:.2%} of its pixels are off ({off:.2%})"
    return ""


def path_of(name: str) -> Path:
    """Path of a golden picture: `light_key` is `golden/light/key.png`."""
    kind, _, rest = name.partition("_")
    return FOLDER / kind / f"{rest}.png" if kind in KINDS else FOLDER / f"{name}.png"


def check_golden(
    picture: Picture, name: str, *, law: Law, regenerate: bool = False, mean: float = 0.5, off: float = 0.002
) -> None:
    """Fail unless `picture` (H, W, 3) keeps `law` and matches the golden picture of that name: at most `mean`
    steps of 255 off on average and a share `off` of pixels. On failure it is saved as NAME.seen.png.
    """
    if not law(picture):
        Image.fromarray(picture).save(FOLDER / f"{name}.seen.png")
        pytest.fail(f"{name}: the picture does not keep its law; see golden/{name}.seen.png")
    path = path_of(name)
    if regenerate:
        path.parent.mkdir(exist_ok=True, parents=True)
        Image.fromarray(picture).save(path, optimize=True)
        assert path.stat().st_size < LARGEST, f"{path} has {path.stat().st_size} bytes: draw it smaller"
        return
    if not path.exists():
        pytest.fail(f"{path} is missing; run pytest --regenerate-goldens, look at it and commit it")
    why = describe_difference(picture, np.asarray(Image.open(path).convert("RGB")), mean=mean, off=off)
    if why:
        Image.fromarray(picture).save(FOLDER / f"{name}.seen.png")
        pytest.fail(f"{name}: {why}; see golden/{name}.seen.png")
