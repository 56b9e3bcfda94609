"""Tests of BodyTracks: the same body in meters in any unit and axes, overrides, and missing bodies."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from live.motion.formats.file_error import MotionFileError
from live.motion.formats.source_motion import SourceMotion
from live.motion.retarget.body_tracks import body_tracks
from tests.motion.retarget.made_source import NAMES, moving_values, source, still


def scale_motion(motion: SourceMotion, factor: float) -> SourceMotion:
    return replace(
        motion,
        offsets=motion.offsets * factor,
        end_offsets=motion.end_offsets * factor,
        translation=motion.translation * factor,
    )


def z_up(motion: SourceMotion) -> SourceMotion:
    """The whole figure rotated so that its height is along z."""
    tip = Rotation.from_euler("X", 90.0, degrees=True)
    rotation, translation = motion.rotation.copy(), motion.translation.copy()
    root = tip * Rotation.from_quat(rotation[:, 0][:, [1, 2, 3, 0]])
    rotation[:, 0] = root.as_quat()[:, [3, 0, 1, 2]]
    translation[:, 0] = tip.apply(translation[:, 0])
    return replace(motion, rotation=rotation, translation=translation)


def test_rest_pose_positions_are_in_meters() -> None:
    tracks = body_tracks(source(still(3), 50.0))
    assert tracks.rate == 50.0
    assert tracks.unit_m == 0.01
    np.testing.assert_allclose(tracks.ankles[0], [[0.09, 0.08, 0.0], [-0.09, 0.08, 0.0]], atol=1e-12)
    np.testing.assert_allclose(tracks.toes[0], [[0.09, 0.02, 0.13], [-0.09, 0.02, 0.13]], atol=1e-12)
    reach = 0.03 + 0.14 + 0.27 + 0.24 + 0.5 * 0.3 * 0.24  # palm: halfway from the wrist to the End Site
    np.testing.assert_allclose(tracks.palms[0, :, 0], [reach, -reach], atol=1e-12)
    assert tracks.names == NAMES
    assert tracks.column("leftFoot") == NAMES.index("LeftFoot")
    assert tracks.column("upperChest") is None


@pytest.mark.parametrize("factor", [0.01, 1.0, 10.0, 1.0 / 2.54])
def test_units_and_axes_give_same_tracks(factor: float) -> None:
    motion = source(moving_values(2.0, 60.0), 60.0)
    plain = body_tracks(motion)
    for other in (scale_motion(motion, factor), z_up(scale_motion(motion, factor))):
        tracks = body_tracks(other)
        np.testing.assert_allclose(tracks.positions, plain.positions, atol=1e-9)
        np.testing.assert_allclose(tracks.palms, plain.palms, atol=1e-9)


def test_given_rate_and_unit_take_precedence() -> None:
    tracks = body_tracks(source(still(3), 120.0), fps=60.0, unit_m=0.02)
    assert (tracks.rate, tracks.unit_m) == (60.0, 0.02)


def test_wrong_format_unit_is_ignored() -> None:
    motion = source(still(3), 60.0)
    assert body_tracks(replace(motion, unit_m=1.0)).unit_m == 0.01
    assert body_tracks(replace(scale_motion(motion, 0.01), unit_m=1.0)).unit_m == 1.0


def test_motion_without_body_is_refused() -> None:
    motion = source(still(3), 60.0)
    chain = replace(motion, parents=np.arange(-1, len(NAMES) - 1, dtype=np.int32))
    nameless = replace(chain, names=tuple(f"joint{n}" for n in range(len(NAMES))))
    with pytest.raises(MotionFileError, match="no joints found"):
        body_tracks(nameless)
    with pytest.raises(MotionFileError, match="no length"):
        body_tracks(scale_motion(motion, 0.0))
