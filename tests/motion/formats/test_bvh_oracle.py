"""Tests of BVH joints against pybvh: the same names and positions in every file that it can read."""

import numpy as np
import pytest

from live.motion.formats.bvh_reader import local_pose
from live.motion.formats.source_motion import world_pose
from tests.fixtures.mocap import mocap_bvh, mocap_file, mocap_index
from tests.fixtures.mostly_long import mostly_long

pybvh = pytest.importorskip("pybvh")

REFUSED = {
    "edge/blender_rigify_metres_freemocap.bvh",  # positions below the root
    "edge/six_channels_everywhere_geno_bind.bvh",
    "edge/makehuman_benchmark_6and3.bvh",
    "walk/figure8_MS2_8Walk_M.bvh",
    "edge/frame_count_off_by_one_boxing.bvh",  # more lines than declared
}
FILES = [
    row["file"]
    for row in mocap_index()
    if row.get("joints") is not None and row["file"] not in REFUSED and row["family"] != "DAZ-43"
]


@pytest.mark.shared
@pytest.mark.filterwarnings("ignore::UserWarning")
@mostly_long("name", [*FILES, "salsa/60_03.bvh"], quick=[*range(0, len(FILES), 3), -1])
def test_joints_match_pybvh(name: str) -> None:
    """pybvh takes the root position from the channels alone, so the root OFFSET is ignored here."""
    theirs = pybvh.read_bvh_file(str(mocap_file(name)))
    motion = mocap_bvh(name)
    assert tuple(theirs.joint_names) == motion.names
    assert theirs.frame_time == pytest.approx(motion.frame_time, rel=1e-4)  # it rounds to whole rates
    frames = np.unique(np.linspace(0, motion.frame_count - 1, 40).astype(int))
    expected = np.stack([theirs.joint_positions(frame=int(frame)) for frame in frames])
    found = world_pose(motion.parents, local_pose(motion, "replace")).positions[frames]
    np.testing.assert_allclose(found, expected, atol=1e-11)
    rotations = theirs.to_quat()[1][frames]
    ours = local_pose(motion).rotation[frames]
    np.testing.assert_allclose(np.abs(np.sum(ours * rotations, axis=-1)), 1.0, atol=1e-12)
