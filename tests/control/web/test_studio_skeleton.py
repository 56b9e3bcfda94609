"""The skeleton of the studio's 3D stage is that of the engine."""

import re
from pathlib import Path

import numpy as np

from live.motion.skeleton import SKELETON

SOURCE = Path(__file__).resolve().parents[3] / "studio" / "src" / "view" / "stage" / "skeleton.ts"


def _numbers(name: str) -> list[int]:
    found = re.search(rf"{name} = \[(.*?)\]", SOURCE.read_text(), re.DOTALL)
    assert found is not None
    return [int(one) for one in re.findall(r"-?\d+", found[1])]


def test_joints_hang_together_as_in_the_engine() -> None:
    assert _numbers("PARENTS") == SKELETON.parents.tolist()
    rest = np.array(_numbers("REST_MM")).reshape(-1, 3) / 1000
    assert np.abs(rest - SKELETON.rest_positions()).max() < 0.001
    head = re.search(r"HEAD_JOINT = (\d+)", SOURCE.read_text())
    assert head is not None
    assert int(head[1]) == SKELETON.index("head")
