"""Size effect against plain cross products, and against what IEEE 528 says of a pendulum's two centres."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from fogkit.imu.size_effect import SizeEffect


@given(st.integers(0, 2**32 - 1))
def test_added_force_is_that_of_a_rigid_body(seed):
    rng = np.random.default_rng(seed)
    alpha, omega = rng.uniform(-5, 5, (2, 4, 3))
    first, second = rng.uniform(-0.1, 0.1, (2, 3, 3))
    added = SizeEffect(acceleration_centres=first, velocity_centres=second).added_force(
        alpha, omega[:, :, None] * omega[:, None, :]
    )
    for i in range(3):
        expected = np.cross(alpha, first[i]) + np.cross(omega, np.cross(omega, second[i]))
        assert_allclose(added[:, i], expected, atol=75 * 0.3 * 1e-15)  # rounding of products of up to 75 * 0.1


def test_centres_apart_along_the_pendulum_read_the_product_of_two_rates():
    # IEEE Std 528-2019, anisoinertia: offset proportional to the product of the rates about input and pendulous axes
    separation, omega = 0.01, np.array([2.0, 3.0, 7.0])
    pendulums = np.roll(np.eye(3), 1, axis=1)  # input axes x, y, z; pendulums along y, z, x
    effect = SizeEffect(velocity_centres=separation * pendulums)
    read = np.diagonal(effect.added_force(np.zeros(3), np.outer(omega, omega)))
    assert_allclose(read, separation * np.array([2 * 3, 3 * 7, 7 * 2]), rtol=1e-14)


def test_counts_and_defaults():
    centres = np.arange(9.0).reshape(3, 3) / 100
    assert SizeEffect().is_zero
    assert SizeEffect.one_point(centres) == SizeEffect(acceleration_centres=centres, velocity_centres=centres)
    assert SizeEffect.one_point(centres).parameters == 9
    two = SizeEffect(acceleration_centres=centres, velocity_centres=centres + 0.003)
    assert (two.parameters, two.is_zero) == (18, False)
    assert not SizeEffect(velocity_centres=centres).is_zero


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"acceleration_centres": np.zeros(3)}, "`acceleration_centres`"),
        ({"velocity_centres": np.full((3, 3), np.nan)}, "`velocity_centres`"),
        ({"velocity_centres": 30 * np.eye(3)}, "`velocity_centres` must be in .* Multiply millimetres"),
    ],
)
def test_errors_name_the_argument(arguments, message):
    with pytest.raises(ValueError, match=message):
        SizeEffect(**arguments)
