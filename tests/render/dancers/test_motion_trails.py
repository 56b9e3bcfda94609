"""Motion history of ribbons and trails: samples on exact beats at any frame rate."""

import numpy as np
import pytest

from live.base.picture_parameters import STYLE_ADDRESS_PREFIX, group_parameter, picture_row
from live.motion.skeleton import SKELETON
from live.render.adaptive_quality import SOFTWARE
from live.render.dancers.dancer_batch import DancerBatch
from live.render.dancers.motion_trails import SAMPLES, SAMPLES_PER_BEAT, LimbHistory, PoseHistory
from tests.fixtures.mostly_long import mostly_long
from tests.render.poses import ARMS_DOWN, stage_view
from tests.render.test_renderer import scene

pytestmark = pytest.mark.gl
HAND = SKELETON.index("leftHand")


def view_at_beat(beat):
    """Two dancers who walk one metre per beat to the right; the second is absent in the third beat."""
    view = stage_view([(ARMS_DOWN, (beat, 0.0), 0.0, 0), (ARMS_DOWN, (beat, 1.0), 0.0, 1)])
    view.beat = beat
    view.present[1] = not 2.0 < beat < 3.0
    return view


def read_samples(history):
    """The ring buffer with the newest sample first, shape (known, 2, 4, 4)."""
    rows = np.frombuffer(history.texture.read(), np.float32).reshape(SAMPLES + 1, 2, 4, 4)
    newest = int(history.ring[0])
    return rows[(newest - np.arange(history.valid_count)) % SAMPLES]


@mostly_long("rate", [23.0, 60.0, 7.0], quick=[2])
def test_samples_lie_on_exact_beats_at_any_frame_rate(gl_context, rate):
    history = LimbHistory(gl_context, 2)
    for frame in range(int(4.0 * rate)):
        history.update(view_at_beat(0.5 + frame / rate), 2)
    known, last = read_samples(history), 0.5 + (int(4.0 * rate) - 1) / rate
    newest = np.floor(last * SAMPLES_PER_BEAT) / SAMPLES_PER_BEAT
    beats = newest - np.arange(len(known)) / SAMPLES_PER_BEAT
    assert beats[-1] == pytest.approx(0.5 + 1 / SAMPLES_PER_BEAT, abs=1.01 / SAMPLES_PER_BEAT)
    hand = view_at_beat(0.0).joint_position[0, HAND, 0]
    walked = known[:, 0, 0, 0] - beats
    assert np.ptp(walked) < 1e-4  # each sample is where she was at that very beat
    assert walked[0] > hand  # the tip of the hand lies beyond its joint
    assert history.ring[2] == pytest.approx(last - newest)
    away = (beats > 2.0 + 1.0 / rate) & (beats < 3.0 - 1.0 / rate)
    assert (known[away, 1, :, 3] == 0.0).all()
    assert (known[:, 0, :, 3] == 1.0).all()
    history.release()


def test_jump_in_time_clears_history(gl_context):
    history = LimbHistory(gl_context, 2)
    for frame in range(60):
        history.update(view_at_beat(frame / 30.0), 2)
    assert history.valid_count > 20
    for beat in (0.5, 40.0):
        history.update(view_at_beat(beat), 2)
        assert history.valid_count == 0
    history.release()


@pytest.mark.long
def test_each_group_has_trail_poses_at_own_spacing(gl_context):
    crowd = DancerBatch(gl_context, scene(2), SOFTWARE, (64, 64))
    row = picture_row(scene(2))
    for group, spacing in ((0, 1.0), (1, 0.5)):
        row[group_parameter(STYLE_ADDRESS_PREFIX + "trails", group).row_slice] = 1.0
        row[group_parameter(STYLE_ADDRESS_PREFIX + "trails/spacing", group).row_slice] = spacing
    crowd.set_styles(row)
    history = PoseHistory(gl_context, 2)
    for frame in range(100):  # until beat 3.3
        view = view_at_beat(frame / 30.0)
        crowd.update(view, np.array([0, 1, 0], np.float32))
        history.update(view, crowd)
    ages = np.array([history.ages(slot) for slot in range(8)])
    assert sorted(ages[ages[:, 0] >= 0.0, 0]) == pytest.approx([0.3, 1.3, 2.3], abs=1e-5)
    assert sorted(ages[ages[:, 1] >= 0.0, 1])[:6] == pytest.approx([0.3, 0.8, 1.3, 1.8, 2.3, 2.8], abs=1e-5)
    assert (ages[:, 2:] == -1.0).all()
    # the ghost of beat 2 stands where she was then (dual quaternion: translation = 2 dual conj(real))
    slot = int(np.argmin(np.abs(ages[:, 0] - 1.3)))
    real, dual = np.frombuffer(history.textures[slot].read(), np.float32).reshape(2, -1, 2, 4)[0, 0].astype(float)
    x = 2.0 * (-dual[3] * real[0] + dual[0] * real[3] - dual[1] * real[2] + dual[2] * real[1])
    assert x == pytest.approx(2.0, abs=1.0 / 30.0 + 1e-3)
    history.release()
    crowd.release()
