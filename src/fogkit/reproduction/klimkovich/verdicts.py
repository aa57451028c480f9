"""The paper's claims in words, put to simulated recordings: each function says whether one holds as made.

What "small" and "equal" mean is stated with each; the numbers themselves are in `convergence`, `bias_sources` and
`gyro_bias_test`.
"""

from functools import cache

import numpy as np

from fogkit.reproduction.klimkovich import bias_sources, convergence, gyro_bias_test, paper
from fogkit.reproduction.klimkovich.convergence import standard_calibration, standard_trial
from fogkit.reproduction.klimkovich.trials import Trial
from fogkit.units import ARCSEC, PPM

SEEDS = (1, 2, 3)
_ALIKE = 0.05  # relative; two results whose difference this is serve equally well
_NOTHING = 0.1  # arcsec and ppm; a fiftieth of the standard deviations of table 1


def errors(matrix: str = "actual", attitude: str = "model", **trial) -> dict[str, float]:
    """True errors of `standard_calibration`."""
    return standard_trial(**trial).errors(standard_calibration(matrix, attitude, **trial).compensation)


@cache
def errors_with_both_matrices() -> dict[tuple[int, bool], tuple[float, float]]:
    """Seed and noise to the largest error of a gyro angle, arcsec, with the actual and with the model matrix."""
    return {
        (seed, noisy): tuple(
            errors(matrix, seed=seed, noisy=noisy)["gyro_angle_arcsec"] for matrix in ("actual", "model")
        )
        for seed in SEEDS
        for noisy in (False, True)
    }


def actual_matrix_is_more_accurate() -> bool:
    """Whether the model matrix leaves notably more error in any trial."""
    return any(model > (1 + _ALIKE) * actual for actual, model in errors_with_both_matrices().values())


def model_matrix_is_biased() -> bool:
    """Whether the model matrix ends elsewhere, by more than rounding to 0.1 arcsec, without noise."""
    return any(
        convergence.disagreement(standard_calibration("actual", seed=seed), standard_calibration("model", seed=seed))[
            "gyro_angle_arcsec"
        ]
        > _NOTHING
        for seed in SEEDS
    )


@cache
def left_by_the_model_matrix(roughness: float = 5.0, iterations: int = paper.ITERATIONS) -> float:
    """Gyro angle, arcsec, by which the two matrices differ after some iterations from the true start without noise."""
    trial = standard_trial(roughness=roughness)
    one, other = (trial.calibrated(matrix, attitude="true", iterations=iterations) for matrix in ("actual", "model"))
    return convergence.disagreement(one, other)["gyro_angle_arcsec"]


def model_matrix_may_leave_errors() -> bool:
    """Whether on some table that the actual matrix copes with it leaves more than 0.1 arcsec in eight iterations."""
    return left_by_the_model_matrix() > _NOTHING


def actual_matrix_is_faster() -> bool:
    """Whether it needs fewer iterations to the floor of the measurement in every trial without noise."""
    counts = [
        [convergence.iterations_to_floor(standard_calibration(matrix, seed=seed).log) for matrix in ("actual", "model")]
        for seed in SEEDS
    ]
    return all(actual < model for actual, model in counts)


def floors(noisy: bool = True) -> dict[str, float]:
    """Measurement after the last iteration with each matrix, m/s^2: figure 4."""
    return {
        matrix: float(standard_calibration(matrix, noisy=noisy).log["rms_z"].iloc[-1])
        for matrix in ("actual", "model", "printed")
    }


def actual_matrix_has_the_lower_floor() -> bool:
    """Whether the model matrix leaves a notably larger measurement."""
    found = floors()
    return found["model"] > (1 + _ALIKE) * found["actual"]


def calibrates_to_table_1(attitude: str = "model") -> bool:
    """Whether on rough tables, absorbers and all, the true errors stay below the largest deviations of table 1."""
    cells = paper.TABLE_1
    limits = {
        "gyro_angle_arcsec": max(v for n, v in cells.items() if n[:3] == "m_g" and n[-1] != n[-2]),
        "gyro_scale_ppm": max(v for n, v in cells.items() if n[:3] == "m_g" and n[-1] == n[-2]),
        "accelerometer_angle_arcsec": max(v for n, v in cells.items() if n[:3] == "m_a"),
        "accelerometer_bias_um_s2": max(v for n, v in cells.items() if n[:3] == "b_a") / 1e-6,
    }
    found = [errors(attitude=attitude, seed=seed) for seed in SEEDS]
    return all(one[name] < limit for one in found for name, limit in limits.items())


def calibration_works() -> bool:
    """Whether gyro errors of an arcminute and of hundreds of ppm fall to a fortieth in every trial."""
    limit = standard_trial().error / 40
    found = [errors(seed=seed) for seed in SEEDS]
    return all(one["gyro_angle_arcsec"] < limit / ARCSEC and one["gyro_scale_ppm"] < limit / PPM for one in found)


def table_shows_in_a_rotation_only(attitude: str = "model") -> bool:
    """Whether a rough table changes nothing, to 0.1 arcsec and 0.1 ppm, but the axes of the unit."""
    found = errors(attitude=attitude)
    return all(found[name] < _NOTHING for name in found if name != "accelerometer_bias_um_s2")


def size_effect_does_not_enter() -> bool:
    """Whether accelerometers 2 cm apart change any angle or scale factor by less than 0.1 arcsec or ppm."""
    return all(
        max(list(bias_sources.effect(f"size effect, {points}").values())[:4]) < _NOTHING
        for points in ("one point", "two points")
    )


def delays_do_not_enter() -> bool:
    """Whether gyro delays that differ by tenths of a millisecond change nothing by 0.1 arcsec or ppm."""
    return max(list(bias_sources.effect("gyro delays, unequal").values())[:4]) < _NOTHING


def computed_turns_become_true() -> bool:
    """Whether the error of the computed turns falls by two orders in four iterations."""
    first, fourth = convergence.errors_of_turns(standard_trial())
    return bool(fourth < first / 100)


@cache
def _slopes() -> dict[int, np.ndarray]:
    trial = standard_trial()
    return {n: convergence.slopes(table, trial) for n, table in convergence.figures_2_and_3(trial).items()}


def slopes_differ_at_first() -> bool:
    """Whether in the first iteration a slope of test 1 changes by more than itself."""
    before, after = _slopes()[1]
    return bool((np.abs(after - before) > np.abs(before)).any())


def slopes_agree_at_last() -> bool:
    """Whether in the eighth they agree to a hundredth of themselves, which no figure shows."""
    before, after = _slopes()[8]
    return bool((np.abs(after - before) < 0.01 * np.abs(before)).all())


def oscillations_are_size_effect_and_delays() -> bool:
    """Whether, in the axis of the turn, the velocity swings with either and does not without."""
    found = convergence.oscillations()
    return min(found["size effect"], found["delays"]) > 50 * found["none"]


def first_iteration_without_fall(limit: float = 0.1) -> int:
    """First iteration whose measurement is less than a tenth below the one before."""
    z = standard_calibration(noisy=True).log["rms_z"].to_numpy()
    return int(np.argmax(z[1:] > (1 - limit) * z[:-1])) + 2


def corrections_flat_from() -> int:
    """Iteration from which the corrections of the gyro matrix stay within ten times their last value."""
    log = standard_calibration().log["rms_m_g"]
    return int(log.index[(log <= 10 * log.iloc[-1]).to_numpy().argmax()])


def corrections_end_in_rounding() -> bool:
    """Whether the corrections end as some rounding errors of a matrix of ones, and the measurement does not change."""
    log = standard_calibration().log.iloc[-5:]
    eps = np.finfo(float).eps
    return bool(
        (log["rms_m_g"] < 100 * eps).all() and (log["rms_m_g"] > 0).all() and np.ptp(log["rms_z"]) < 1e-6 * 1e-3
    )


def levelling_removes_the_tilt() -> bool:
    """Whether a start from the first dwell takes the scale factors of (26) to 0.1 ppm and lessens the other errors."""
    model, levelled = errors(), errors(attitude="levelled")
    return levelled["accelerometer_scale_ppm"] < _NOTHING and levelled["gyro_angle_arcsec"] < model["gyro_angle_arcsec"]


def heading_drops_out_of_the_biases() -> bool:
    """Whether a heading that is wrong by 1e-3 rad changes no gyro bias by a hundredth of the bias of (33)."""
    return bool(np.abs(gyro_bias_test.effect_of_start(2)).max() < paper.GYRO_BIAS_LEFT / 100)


@cache
def measurement_of_a_perfect_unit(rate: float) -> float:
    """Measurement, m/s^2, that the mechanisation makes of perfect readings on an ideal table."""
    trial = Trial(error=0.0, accelerometer_bias=0.0, roughness=0.0, rate=rate)
    return float(trial.calibrated(attitude="true", iterations=1).log["rms_z"].iloc[0])


def algorithm_adds_a_small_error() -> bool:
    """Whether it is not zero, is far below the noise, and falls with the step."""
    slow, fast = (measurement_of_a_perfect_unit(rate) for rate in (50.0, 100.0))
    return 0 < fast < slow / 4 and slow < 1e-3 * floors()["actual"]
