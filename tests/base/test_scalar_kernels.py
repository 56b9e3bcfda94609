"""Scalar kernels against the math module and their laws."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.base import scalar_kernels as kernels


@given(st.floats(-1e4, 1e4))
def test_wrapped_angle_is_the_same_angle(angle):
    wrapped = kernels.angle_wrap(angle)
    assert -math.pi <= wrapped < math.pi + 1e-9
    assert math.cos(wrapped) == pytest.approx(math.cos(angle), abs=1e-9)
    assert math.sin(wrapped) == pytest.approx(math.sin(angle), abs=1e-9)


@given(st.floats(-0.5, 1.5), st.floats(0, 0.5))
def test_ease_is_monotonic_symmetric_and_flat_at_ends(t, more):
    assert kernels.ease(t) <= kernels.ease(t + more) + 1e-12
    assert kernels.ease(t) + kernels.ease(1 - t) == pytest.approx(1.0)
    assert kernels.ease(1e-4) < 1e-6


@given(st.floats(-5, 5), st.floats(-5, 5), st.floats(0.01, 2), st.floats(0, 1), st.floats(0, 1))
def test_damper_is_independent_of_time_steps(value, goal, halflife, first, second):
    whole = kernels.damper(value, goal, halflife, first + second)
    parts = kernels.damper(kernels.damper(value, goal, halflife, first), goal, halflife, second)
    assert parts == pytest.approx(whole, abs=1e-9)
    assert kernels.damper(value, goal, halflife, halflife) == pytest.approx((value + goal) / 2, abs=1e-6)
