"""Whether statements of the slides about temperature (section 3.4) hold in the networks of `fogkit.thermal`."""

import numpy as np

from fogkit.reproduction.beihang.temperature_drift import field_in_unit, short_run_limit, steady_state_drift
from fogkit.reproduction.beihang.temperature_points import points_needed
from fogkit.reproduction.beihang.temperature_tests import TRUE_POINTS
from fogkit.reproduction.beihang.temperature_transfer import (
    gyro_level_against_system_level,
    repeatability,
    start_up_against_steady_state,
)
from fogkit.thermal import experiment
from fogkit.units import HOUR

EXACT = 1e-6
"""Noise of thermometers that is none, K."""


def _field_is_another_one() -> bool:
    field = field_in_unit()
    return field.in_unit > 10 * field.alone


def _gyro_level_does_not_replace() -> bool:
    levels = gyro_level_against_system_level()
    return min(levels.ratio, levels.gyro_in_unit / levels.gyro_at_gyro) > 3


def _more_so_for_higher_accuracy() -> bool:
    coarse, fine = (gyro_level_against_system_level(factor).ratio for factor in (1.0, 1 / 3))
    return fine > 2 * coarse


def _what_does_not_repeat_is_left() -> bool:
    found = repeatability()
    return bool((np.diff(found.left) > 0).all() and (np.diff(found.removed) < 0).all())


def _long_runs_need_a_model() -> bool:
    gyro, limit = experiment.example_gyro(), short_run_limit()
    noise = gyro.angle_random_walk / np.sqrt(HOUR)
    return limit.after_hour > 3 * max(gyro.bias_repeatability, noise)


def _ambient_disturbs() -> bool:
    drift = steady_state_drift()
    return drift.deviation > 3 * max(drift.noise, drift.repeatability)


def _one_law_serves_both() -> bool:
    left = start_up_against_steady_state(thermometer_noise=EXACT)
    return left.steady_in_start < 1.5 * left.start_in_start


def _one_point_does_not() -> bool:
    left = start_up_against_steady_state(("coil_top",), thermometer_noise=EXACT)
    return left.start_in_steady > 2 * left.steady_in_steady


def _pruning_finds_the_points() -> bool:
    return set(points_needed().kept) == set(TRUE_POINTS)


STATEMENTS = {
    "system": _field_is_another_one,
    "not-replaced": _gyro_level_does_not_replace,
    "more-so": _more_so_for_higher_accuracy,
    "repeatable": _what_does_not_repeat_is_left,
    "long": _long_runs_need_a_model,
    "steady-ambient": _ambient_disturbs,
    "steady-similar": _one_law_serves_both,
    "steady-mechanism": _one_point_does_not,
    "steady-pruning": _pruning_finds_the_points,
}
"""Statements of the slides by the end of their row in the ledger: whether they hold in the simulated networks."""
