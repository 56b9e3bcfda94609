"""Tests of rotation on the stage plane."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.motion.pose.yaw_kernels import yaw_rotate


@given(st.floats(-4, 4), st.floats(-4, 4), st.floats(-7, 7))
def test_positive_yaw_turns_audience_direction_toward_plus_x(x, z, yaw):
    """K001's rotation: as complex numbers x + iz it is a multiplication by exp(-i yaw)."""
    turned = complex(x, z) * np.exp(-1j * yaw)
    assert yaw_rotate(x, z, yaw) == pytest.approx((turned.real, turned.imag), abs=1e-9)
    assert yaw_rotate(0.0, 1.0, math.pi / 2) == pytest.approx((1.0, 0.0), abs=1e-12)
