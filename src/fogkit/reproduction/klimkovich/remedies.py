"""What helps against each thing that biases the result: simulated calibrations before and after, free of noise.

The sources themselves are in `fogkit.reproduction.klimkovich.bias_sources`, one at a time. Here:

- a start of unknown attitude: level it, and leave the unit where the turn before has left it, so that its heading is
  carried on by its own gyros (`starts`);
- gyros of unequal delays: turn slowly, turn back as well, or estimate the delays (`delays`);
- gyro biases: calibrate them and the rest in turns (`bias_rounds`);
- all at once, with noise: 59 states in place of 15 (`everything`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from fogkit.calibration.navigation_based import Compensation, batch, estimate_gyro_biases
from fogkit.calibration.velocity_noise import SensorNoise
from fogkit.imu.size_effect import SizeEffect
from fogkit.noise.processes import RandomErrors
from fogkit.reproduction.klimkovich import paper
from fogkit.reproduction.klimkovich.estimates import LATITUDE
from fogkit.reproduction.klimkovich.gyro_delays import reversed_test
from fogkit.reproduction.klimkovich.trials import ANGLE_RANDOM_WALK, VELOCITY_RANDOM_WALK, Trial
from fogkit.stand.turn_motion import TurnMotion
from fogkit.stand.turn_tests import TurnTest, bias_test, nine_tests
from fogkit.units import MILLISECOND

if TYPE_CHECKING:
    from pandas import DataFrame

ITERATIONS = 8
GYRO_DELAYS = (0.1 * MILLISECOND, -0.1 * MILLISECOND, 0.2 * MILLISECOND)
BIASES = (paper.GYRO_BIAS_LEFT,) * 3
BIAS_TEST_RATE = 50.0
"""Samples per second of the gyro-bias test, which is long and has one slow turn."""

NOISE = SensorNoise(
    gyros=RandomErrors(angle_random_walk=ANGLE_RANDOM_WALK),
    accelerometers=RandomErrors(angle_random_walk=VELOCITY_RANDOM_WALK),
)
"""Random errors of a noisy `Trial`, for the weights of the batch estimate.

:meta hide-value:
"""

_SETTLED = 8  # steps of a fixed point that contracts by the sag in each: 1e-2 on a very rough table


@dataclass(frozen=True, kw_only=True, eq=False)
class StayingTrial(Trial):
    """Trial on a table that does not go back to its marks where the plan goes on from the attitude before."""

    @cached_property
    def motions(self) -> tuple[TurnMotion, ...]:
        """What the table does: errors of turns add up from test to test."""
        found: list[TurnMotion] = []
        for motion in super().motions:
            if found and np.allclose(found[-1].test.C_b_n_end, motion.test.C_b_n, rtol=0, atol=1e-9):
                motion = _begun_at(motion, found[-1].C_b_n(found[-1].duration))
            found.append(motion)
        return tuple(found)


def _begun_at(motion: TurnMotion, C_b_n: ArrayLike) -> TurnMotion:
    """The motion from another attitude of the sensors at the start; how they sag depends on it a little."""
    for _ in range(_SETTLED):
        motion = replace(motion, C_case_n=C_b_n @ motion.C_b_n(0.0).T @ motion.C_case_n)
    return motion


def starts(seed: int = 1, roughness: float = 1.0) -> "DataFrame":
    """True errors by what is known of the attitude at the start, and by what the table does between tests.

    Returns
    -------
    DataFrame
        Index: "returns" (the table drives to its marks before each test, with new errors) or "stays", and the attitude
        at the start, of `fogkit.reproduction.klimkovich.trials.ATTITUDES`. Columns as `Trial.errors`.
    """
    import pandas as pd

    trials = {
        kind: make(seed=seed, roughness=roughness) for kind, make in (("returns", Trial), ("stays", StayingTrial))
    }
    rows = {
        (kind, attitude): trial.errors(trial.calibrated(attitude=attitude, iterations=ITERATIONS).compensation)
        for kind, trial in trials.items()
        for attitude in ("model", "levelled", "carried", "true")
    }
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis(["table", "start"])


def scale_factors(roughness: float) -> dict[str, float]:
    """Largest error of the accelerometer scale factors, ppm, from the model start: by (26), and by all dwells."""
    trial = Trial(roughness=roughness)
    found = {}
    for method, rows in (("pairs", 2), ("all", 4)):
        weights = np.eye(rows * len(trial.plan))
        calibration = trial.calibrated(scale_factor=method, noise=weights, iterations=ITERATIONS)
        found[method] = trial.errors(calibration.compensation)["accelerometer_scale_ppm"]
    return found


def plans() -> dict[str, tuple[TurnTest, ...]]:
    """Plans against unequal delays: the nine tests; half as fast; each twice; each forth and back."""
    nine = nine_tests()
    return {
        "nine tests": nine,
        "half as fast": nine_tests(turn_duration=2 * nine[0].turn_duration),
        "each twice": nine + tuple(replace(test, label=f"{test.label} again") for test in nine),
        "forth and back": nine + tuple(map(reversed_test, nine)),
    }


def delays(seeds: Sequence[int] = (1, 2, 3), delay: ArrayLike = GYRO_DELAYS) -> "DataFrame":
    """Largest error of a gyro angle, arcsec, by plan and seed: columns as `plans`."""
    import pandas as pd

    rows = {
        seed: {name: _angle_error(Trial(seed=seed, gyro_delay=delay, plan=plan)) for name, plan in plans().items()}
        for seed in seeds
    }
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("seed")


def _angle_error(trial: Trial) -> float:
    found = trial.calibrated(attitude="true", iterations=ITERATIONS)
    return trial.errors(found.compensation)["gyro_angle_arcsec"]


def delays_estimated(seed: int = 1, delay: ArrayLike = GYRO_DELAYS) -> tuple[float, batch.BatchCalibration]:
    """Largest error of a gyro angle, arcsec, with delays as states of a batch estimate, and that estimate."""
    trial = Trial(seed=seed, gyro_delay=delay)
    start = trial.calibrated(attitude="true", iterations=ITERATIONS).compensation
    found = batch.estimate(
        trial.recordings, trial.plan, LATITUDE, NOISE, start=start, initial_attitude=trial.starts, groups=("delay",)
    )
    return trial.errors(found.compensation)["gyro_angle_arcsec"], found


def bias_rounds(attitude: str = "levelled", method: str = "slopes", *, rounds: int = 2, seed: int = 1) -> "DataFrame":
    """Calibration of matrices and of gyro biases in turns, from gyro biases of `BIASES`.

    Parameters
    ----------
    attitude : {"levelled", "model"}, optional
        At the start of the gyro-bias test. The nine tests start from the true one.
    method : {"slopes", "rates"}, optional
        As of `fogkit.calibration.navigation_based.estimate_gyro_biases`.
    rounds : int, optional
        How often the biases are calibrated.
    seed : int, optional
        Of the trial.

    Returns
    -------
    DataFrame
        Index: number of calibrations of the biases before. Columns as `Trial.errors`, and ``gyro_bias``: largest error
        of a bias, rad/s.
    """
    import pandas as pd

    trial = Trial(seed=seed, gyro_bias=BIASES)
    still = Trial(seed=seed, gyro_bias=BIASES, plan=(bias_test(),), rate=BIAS_TEST_RATE)
    compensation, rows = Compensation(), []
    for number in range(rounds + 1):
        found = trial.calibrated(attitude="true", iterations=ITERATIONS, start=compensation)
        compensation = found.compensation
        left = np.abs(compensation.gyro_bias - trial.truth.gauged().gyro_bias).max()
        rows.append(trial.errors(compensation) | {"gyro_bias": left})
        if number < rounds:
            compensation = estimate_gyro_biases(
                still.recordings[0],
                still.plan[0],
                compensation,
                LATITUDE,
                method=method,
                initial_attitude=attitude,
            ).compensation
    return pd.DataFrame(rows, index=pd.RangeIndex(rounds + 1, name="rounds"))


@dataclass(frozen=True, eq=False)
class Everything:
    """Result of `everything`.

    Attributes
    ----------
    trial : Trial
        Recordings.
    fifteen : Compensation
        As the paper calibrates, from the plan's attitudes.
    states : BatchCalibration
        All 59 states, from the same recordings.
    """

    trial: Trial
    fifteen: Compensation
    states: batch.BatchCalibration


def everything(seed: int = 1, *, noisy: bool = True, prior: Mapping[str, float] | None = None) -> Everything:
    """A unit with delays, size effect and gyro biases on a rough table, by 15 parameters and by 59 states.

    Parameters
    ----------
    seed : int, optional
        Of the trial.
    noisy : bool, optional
        Whether its recordings have noise; the weights of the states assume it in any case.
    prior : mapping of str to float, optional
        As of `fogkit.calibration.navigation_based.batch.estimate`.
    """
    centres = np.random.default_rng([seed, 4]).normal(0, 0.02, (3, 3))
    trial = Trial(
        seed=seed,
        noisy=noisy,
        gyro_bias=BIASES,
        gyro_delay=GYRO_DELAYS,
        accelerometer_delay=(1 * MILLISECOND, -0.5 * MILLISECOND, 2 * MILLISECOND),
        size_effect=SizeEffect.one_point(centres),
    )
    fifteen = trial.calibrated(iterations=ITERATIONS).compensation
    states = batch.estimate(trial.recordings, trial.plan, LATITUDE, NOISE, start=fifteen, prior=prior)
    return Everything(trial, fifteen, states)
