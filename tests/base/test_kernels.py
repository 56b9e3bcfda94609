"""Scalar kernels against scipy's rotations and laws."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from live.base import kernels

numbers = st.floats(-1, 1)
quaternions = st.tuples(numbers, numbers, numbers, numbers).filter(lambda q: sum(v * v for v in q) > 0.1)


def unit(q):
    return tuple(np.array(q) / np.linalg.norm(q))


def scipy_of(q):
    return Rotation.from_quat([q[1], q[2], q[3], q[0]])


@given(quaternions, quaternions, st.tuples(numbers, numbers, numbers))
def test_products_and_rotations(a, b, v):
    a, b = unit(a), unit(b)
    product = kernels.quat_mul(*a, *b)
    assert kernels.quat_rotate(*product, *v) == pytest.approx((scipy_of(a) * scipy_of(b)).apply(v), abs=1e-9)


@given(quaternions, quaternions, st.floats(0, 1))
def test_slerp_is_the_shorter_arc(a, b, t):
    a, b = unit(a), unit(b)
    assume(abs(np.dot(a, b)) > 1e-3)  # half a turn apart there are two shortest ways
    found = kernels.quat_slerp(*a, *b, t)
    assert np.linalg.norm(found) == pytest.approx(1.0)
    wanted = Slerp([0, 1], Rotation.concatenate([scipy_of(a), scipy_of(b)]))(t)
    assert (scipy_of(found) * wanted.inv()).magnitude() < 2e-4  # the chord stands in for arcs under 3.6 degrees


@given(st.floats(-1e4, 1e4))
def test_wrapped_angles_are_the_same_angle(angle):
    wrapped = kernels.angle_wrap(angle)
    assert -math.pi <= wrapped < math.pi + 1e-9
    assert math.cos(wrapped) == pytest.approx(math.cos(angle), abs=1e-9)
    assert math.sin(wrapped) == pytest.approx(math.sin(angle), abs=1e-9)


@given(st.floats(-0.5, 1.5), st.floats(0, 0.5))
def test_ease_is_monotonic_symmetric_and_stands_still_at_both_ends(t, more):
    assert kernels.ease(t) <= kernels.ease(t + more) + 1e-12
    assert kernels.ease(t) + kernels.ease(1 - t) == pytest.approx(1.0)
    assert kernels.ease(1e-4) < 1e-6


@given(st.floats(-5, 5), st.floats(-5, 5), st.floats(0.01, 2), st.floats(0, 1), st.floats(0, 1))
def test_the_damper_does_not_depend_on_how_time_is_cut(value, goal, halflife, first, second):
    whole = kernels.damper(value, goal, halflife, first + second)
    parts = kernels.damper(kernels.damper(value, goal, halflife, first), goal, halflife, second)
    assert parts == pytest.approx(whole, abs=1e-9)
    assert kernels.damper(value, goal, halflife, halflife) == pytest.approx((value + goal) / 2, abs=1e-6)
