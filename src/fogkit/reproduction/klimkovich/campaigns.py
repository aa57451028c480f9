"""Are the standard deviations of the nine tests true? Many calibrations of one simulated unit, with new noise in each.

`noise_runs` makes what is stored in ``data/derived/klimkovich_noise_runs.csv``: the call is in its docstring. The unit
stands on a rough table without shock absorbers; the attitudes at the start are the true ones and the iteration sets out
from the truth, so that nothing but noise makes an error.
"""

from collections.abc import Iterable
from concurrent.futures import Executor
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fogkit import checks
from fogkit.calibration.navigation_based import Compensation, calibrate, differences
from fogkit.calibration.turn_plans import TableLimits, candidates, optimise
from fogkit.calibration.uncertainty import plan_covariance
from fogkit.calibration.velocity_noise import SensorNoise
from fogkit.campaign import map_cases
from fogkit.imu.triads import LinearTriad
from fogkit.imu.unit import MeasurementUnit, Sensors
from fogkit.noise import RandomErrors
from fogkit.stand.rough_table import RoughTable
from fogkit.stand.turn_recordings import ExactInputs, exact_inputs
from fogkit.stand.turn_tests import TurnTest, nine_tests
from fogkit.units import ARCSEC, DEG, DEG_PER_HOUR, DEG_PER_SECOND_SQUARED, DEG_PER_SQRT_HOUR, MICRO_G, MILLI_G, PPM

if TYPE_CHECKING:
    from pandas import DataFrame

LATITUDE = 53.9 * DEG
RATE = 100.0

NOISE = {
    "white": SensorNoise(accelerometers=RandomErrors(quantization=1e-3)),
    "walk": SensorNoise(
        gyros=RandomErrors(angle_random_walk=0.002 * DEG_PER_SQRT_HOUR),
        accelerometers=RandomErrors(angle_random_walk=10 * MICRO_G),
    ),
}
"""White noise of the velocity, 1 mm/s in each sample; random walks of angle and velocity as of good sensors."""

TOLERATED = np.array([ARCSEC] * 3 + [PPM if i % 4 == 0 else ARCSEC for i in range(9)] + [10 * MICRO_G] * 3)
"""Sizes in which the "A" plan counts the fifteen errors: 1 arcsec, 1 ppm, 10 micro-g."""

PLANS = ("paper", "A")
WEIGHTS = ("residuals", "noise")


@lru_cache
def plan_of(name: str) -> tuple[TurnTest, ...]:
    """The nine tests, or twelve that are A-optimal in no more time, with the rate of the nine."""
    checks.option("name", name, PLANS)
    if name == "paper":
        return nine_tests()
    limits = TableLimits(acceleration=252 * DEG_PER_SECOND_SQUARED)  # ramps of 0.5 s, as the table has
    time = limits.duration(nine_tests())
    rng = np.random.default_rng(1)
    found = optimise(
        candidates(limits), 12, NOISE["walk"], sizes=TOLERATED, time=time, rng=rng, starts=5, limits=limits
    )
    return found.plan


@lru_cache
def inputs(case: str, plan: str) -> tuple[ExactInputs, NDArray[np.float64]]:
    """What acts on the unit in each test of a plan, and the true attitudes at the start, shape (tests, 3, 3)."""
    rng = np.random.default_rng(2022)
    noise = NOISE[checks.option("case", case, NOISE)]
    unit = MeasurementUnit(
        gyros=_sensors(rng, 1 * DEG_PER_HOUR, noise.gyros[0]),
        accelerometers=_sensors(rng, 1 * MILLI_G, noise.accelerometers[0]),
    )
    table = RoughTable.typical(LATITUDE, absorber=None)
    motions = table.motions(plan_of(plan), rng)
    return exact_inputs(unit, motions, RATE), np.stack([motion.C_b_n(0.0) for motion in motions])


def noise_run(seed: int, case: str, plan: str, weights: str) -> dict[str, float | int | str]:
    """One calibration: errors over their stated standard deviations, and chi-squares.

    Parameters
    ----------
    seed : int
        Of the run's own random generator.
    case : {"white", "walk"}
        Which noise (`NOISE`).
    plan : {"paper", "A"}
        Which plan (`plan_of`).
    weights : {"residuals", "noise"}
        Whether weights and standard deviations come from the residuals, (21)-(27) and scale factors by (26), or from
        `fogkit.calibration.uncertainty` with the scale factors among the parameters.

    Returns
    -------
    dict
        The arguments; by parameter ``(estimate - truth) / standard deviation``; ``nees`` of the parameters of the
        solution and its ``parameters``, 15 or 18; ``chi_square`` of the residuals and ``degrees_of_freedom``.
    """
    exact, starts = inputs(case, plan)
    tests, truth = plan_of(plan), Compensation.from_unit(exact.unit)
    by_noise = checks.option("weights", weights, WEIGHTS) == "noise"
    result = calibrate(
        exact.record(np.random.default_rng(seed)),
        tests,
        LATITUDE,
        initial_attitude=starts,
        start=truth,
        iterations=4,
        tolerance=0.01,
        scale_factor="all" if by_noise else "pairs",
        noise=plan_covariance(tests, 1 / RATE, NOISE[case], scale_factors=True) if by_noise else None,
    )
    errors = differences(result.compensation, truth)
    names = result.solution.names
    deviation = dict(zip(names, result.solution.standard_deviation, strict=True))
    deviation |= {f"m_a_{i}{i}": sd for i, sd in zip((1, 2, 3), result.scale_factor_deviation, strict=True)}
    found = np.array([errors[name] for name in names])
    return {
        **{"seed": seed, "case": case, "plan": plan, "weights": weights},
        **{name: float(errors[name] / sd) for name, sd in deviation.items()},
        "nees": float(found @ np.linalg.solve(result.solution.covariance, found)),
        "parameters": len(names),
        "chi_square": result.solution.chi_square,
        "degrees_of_freedom": result.solution.degrees_of_freedom,
    }


def noise_runs(
    seeds: Iterable[int] = range(600), *, executor: Executor | None = None, progress: bool | str = False
) -> "DataFrame":
    """All runs: white noise with the paper's weights, random walks with either, and the better plan.

    ``noise_runs().to_csv("data/derived/klimkovich_noise_runs.csv", index=False, float_format="%.6f")`` takes some
    minutes on two cores and writes the stored table.

    Parameters
    ----------
    seeds : iterable of int, optional
        Seeds of the runs of each kind.
    executor, progress
        As in `fogkit.campaign.map_cases`.

    Returns
    -------
    DataFrame
        One row for each run, columns as `noise_run` gives them.
    """
    import pandas as pd

    kinds = (
        ("white", "paper", "residuals"),
        ("white", "paper", "noise"),
        ("walk", "paper", "residuals"),
        ("walk", "paper", "noise"),
        ("walk", "A", "noise"),
    )
    cases = [
        {"seed": seed, "case": case, "plan": plan, "weights": weights}
        for case, plan, weights in kinds
        for seed in seeds
    ]
    return pd.DataFrame(map_cases(noise_run, cases, executor=executor, progress=progress))


def _sensors(rng: np.random.Generator, bias: float, random: RandomErrors) -> Sensors:
    """Sensors with errors as from the factory: 5e-4 in scale and direction."""
    matrix = np.eye(3) + 5e-4 * rng.standard_normal((3, 3))
    return Sensors(triad=LinearTriad(bias=bias * rng.standard_normal(3), matrix=matrix), random=random)
