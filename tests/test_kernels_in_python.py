"""The kernels as plain Python: compiled code reads beyond the end of an array in silence, Python raises IndexError."""

import os
import subprocess
import sys

import pytest

from tests.places import ROOT

TESTS = (
    "tests/base/test_scalar_kernels.py",
    "tests/motion/test_kernels.py",
    "tests/motion/partner_live/test_live.py::test_beats_of_the_clock_bound_the_units",
    "tests/motion/partner/test_decode.py::test_the_recurrence_written_plainly_gives_the_same_score",
    "tests/motion/capture/test_leading.py",
    "tests/motion/capture/test_capture_kernels.py",
    "tests/motion/capture/test_wearing.py",
    "tests/motion/pose/test_inertialization_kernels.py::test_the_legs_alone_keep_the_same_differences",
    "tests/motion/pose/test_pose_pipeline.py",
    "tests/motion/texture/test_live_texture_kernels.py",
    "tests/motion/pose/test_turning_kernels.py",
    "tests/motion/formats/test_bvh_numbers.py",
    "tests/graph/test_motion_graph.py",
    "tests/render/test_render_kernels.py",
    "tests/agents/test_steering_kernels.py",
    "tests/agents/crowd/test_cells.py",
    "tests/agents/crowd/test_kernels.py",
    "tests/agents/crowd/test_reynolds_avoidance_kernels.py",
    "tests/agents/evolutions/test_kernels.py",
    "tests/agents/formations/test_blue_noise_kernels.py",
    "tests/agents/goals/test_goals.py",
    "tests/agents/separation/test_parting.py::test_a_crowd_in_one_place_parts_when_it_may",
    "tests/agents/elements/test_sources.py",
    "tests/agents/separation/test_threats.py::test_things_are_seen_farther_ahead_than_dancers",
)
LEFT_OUT = (  # seconds of a crowd's motion are minutes of plain Python, and Python's floor refuses infinity
    "spreading_from or order_of_the or waits_for or only_the_nearest or prediction or head_on or "
    "repelled_agents or every_edit or threads or formula or same_again_is_bit or exactly_symmetric or sleepers_lie or "
    "force_laws or line_attracts or d_s or many or place_is_no_number"
)


@pytest.mark.long
def test_kernels_stay_within_their_arrays():
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-q",
        "-n",
        "0",
        "-p",
        "no:cacheprovider",
        *TESTS,
        "-k",
        f"not ({LEFT_OUT})",
    ]
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    result = subprocess.run(
        command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=300, check=False
    )
    assert result.returncode == 0, result.stdout[-4000:]
    assert " passed" in result.stdout
