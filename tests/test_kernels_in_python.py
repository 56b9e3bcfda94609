"""The kernels as plain Python: compiled code reads beyond the end of an array silently, Python raises IndexError."""

import os
import subprocess
import sys

import pytest

from tests.places import ROOT

TESTS = (
    "tests/base/test_scalar_kernels.py",
    "tests/motion/test_kernels.py",
    "tests/motion/partner_live/test_live.py::test_units_begin_on_clock_beats",
    "tests/motion/partner/test_decode.py::test_score_equals_direct_recurrence",
    "tests/motion/capture/test_leading.py",
    "tests/motion/capture/test_capture_kernels.py",
    "tests/motion/capture/test_wearing.py",
    "tests/motion/pose/test_inertia.py::test_legs_only_skeleton_has_same_differences",
    "tests/motion/pose/test_pose_pipeline.py",
    "tests/motion/texture/test_live_texture_kernels.py",
    "tests/motion/pose/test_turning_kernels.py",
    "tests/motion/formats/test_bvh_numbers.py",
    "tests/graph/test_motion_graph.py",
    "tests/render/body/test_implicit_surface.py",
    "tests/render/body/test_simplify.py",
    "tests/render/passes/test_world_parts.py",
    "tests/render/test_render_kernels.py",
    "tests/agents/test_steering_kernels.py",
    "tests/agents/crowd/test_cells.py",
    "tests/agents/crowd/test_kernels.py",
    "tests/agents/crowd/test_reynolds_avoidance_kernels.py",
    "tests/agents/evolutions/test_kernels.py",
    "tests/agents/formations/test_blue_noise_kernels.py",
    "tests/agents/goals/test_goals.py",
    "tests/agents/separation/test_parting.py::test_coincident_places_separate_within_limit",
    "tests/agents/elements/test_sources.py",
    "tests/agents/separation/test_threats.py::test_obstacles_have_longer_prediction_range_than_dancers",
)
LEFT_OUT = (  # too slow in plain Python, or Python's floor refuses infinity
    "test_bodies_have_the_field_and_the_width_of_numpy",
    "test_toes_and_limbs_have_the_cross_sections_of_scipy",
    "test_ease_is_monotonic_symmetric_and_flat_at_ends",
    "test_amplitude_matches_t058_formula",
    "test_dancers_are_independent_of_others_and_threads",
    "test_bone_lengths_stay_with_all_edits",
    "test_head_turn_is_continuous_over_spin",
    "test_eased_share_matches_closed_form",
    "test_advance_along_line_passes_corners_and_stops_at_end",
    "test_agent_with_non_finite_position_is_in_a_cell",
    "test_head_on_force_is_power_law_gradient",
    "test_all_coincident_agents_are_counted",
    "test_agent_closer_than_d_s_slows_down",
    "test_head_on_agents_pass_without_contact",
    "test_force_laws_match_thesis_with_nearest_source_only",
    "test_line_attracts_to_its_nearest_point",
    "test_agents_on_repulsor_separate_in_seeded_random_directions",
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
        f"not ({' or '.join(LEFT_OUT)})",
    ]
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    result = subprocess.run(
        command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=300, check=False
    )
    assert result.returncode == 0, result.stdout[-4000:]
    assert " passed" in result.stdout
