"""Error model of the filter with the Earth's axis against differences of the nonlinear equations, and against (8)."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fogkit.constants import STANDARD_GRAVITY
from fogkit.gyrocompass import mechanisation
from fogkit.gyrocompass.filters import wander_model
from fogkit.rotation import dcm_from_rotvec

# steps at which central differences of the fourth order are right to 1e-9 of the largest entry
STEPS = np.array([1e-3] * 3 + [1.0] * 3 + [1e-3, 1e-3, 1000.0] + [1e-3] * 8)


def cases(number):
    rng = np.random.default_rng(11)
    for _ in range(number):
        C = dcm_from_rotvec(rng.uniform(-2, 2, 3))
        position = [rng.uniform(-1.5, 1.5), rng.uniform(-3, 3), rng.uniform(0, 2e4)]
        state = np.array([*rng.uniform(-200, 200, 3), *position, *rng.uniform(-1, 1, 2)])
        yield C, state, rng.uniform(-1, 1, 3), rng.uniform(-15, 15, 3), rng.uniform(-3, 3), rng.uniform(-0.6, 0.6)


def differences(C, state, rates, force, angle, rate, pushed, yaw):
    """Rate of each error per error, the attitude's from the nonlinear motion of two attitudes."""

    # where the vessel does not manoeuvre, the direction of the axis as it is computed turns what tilts do
    along, abeam = state[6:8] / np.hypot(*state[6:8])
    fixed = None if pushed else np.array([[along, -abeam], [abeam, along]])

    def motion(x):
        readings = rates * (1 + x[14:]) + x[11:14]
        turned = dcm_from_rotvec(x[:3]) @ C
        hull = mechanisation.hull_rate(readings, angle, rate)
        turn, rest = wander_model.wander_rate(turned, state + x[3:11], hull, force, STANDARD_GRAVITY, fixed, yaw)
        hull = mechanisation.hull_rate(rates, angle, rate)
        still, _ = wander_model.wander_rate(C, state, hull, force, STANDARD_GRAVITY, fixed, yaw)
        # C_est = exp(x) C: the rate of exp(x) in w is turn - exp(x) still
        rate_of_error = turn - dcm_from_rotvec(x[:3]) @ still
        return np.array([*rate_of_error, *rest])

    columns = []
    for h, e in zip(STEPS, np.eye(17), strict=True):
        one, two = (motion(k * h * e) - motion(-k * h * e) for k in (1, 2))
        columns.append((8 * one - two) / (12 * h))
    return np.array(columns).T


@pytest.mark.parametrize(("pushed", "yaw"), [(False, 0.0), (False, 0.3), (True, 0.0)])
def test_error_model_against_differences(pushed, yaw):
    for case in cases(12):
        C, state, rates, force, angle, _ = case
        F = wander_model.wander_matrix(C, state, rates, force, angle, STANDARD_GRAVITY, pushed, yaw)
        numeric = differences(*case, pushed, yaw)
        assert not F[11:].any()
        for block in (slice(0, 3), slice(3, 6), slice(6, 9), slice(9, 11)):  # each of one unit
            largest = np.abs(numeric[block]).max(axis=0)
            scale = np.where(largest > 0, largest, 1)
            # 1e-6 of the column is asked of the thesis's model; the differences are right to 1e-8
            assert_allclose(F[block] / scale, numeric[block] / scale, atol=1e-6)
