"""Are the standard deviations of the nine tests true? Many calibrations of one simulated unit, with new noise in each.

`noise_runs` makes what is stored in ``data/derived/klimkovich_noise_runs.csv``: the call is in its docstring. The unit
stands on a rough table without shock absorbers; the attitudes at the start are the true ones and the iteration sets out
from the truth, so that nothing but noise makes an error. `left_out` does the opposite: no noise, and one effect at a
time that the paper's fifteen parameters do not know.
"""

from collections.abc import Iterable
from concurrent.futures import Executor
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fogkit import checks
from fogkit.calibration.navigation_based import Compensation, batch, calibrate, differences
from fogkit.calibration.turn_plans import TableLimits, candidates, optimise
from fogkit.calibration.uncertainty import plan_covariance
from fogkit.calibration.velocity_noise import SensorNoise
from fogkit.campaign import map_cases
from fogkit.imu.size_effect import SizeEffect
from fogkit.imu.triads import LinearTriad
from fogkit.imu.unit import MeasurementUnit, Sensors
from fogkit.noise import RandomErrors
from fogkit.stand.rough_table import RoughTable
from fogkit.stand.turn_motion import TurnMotion
from fogkit.stand.turn_recordings import ExactInputs, exact_inputs, record
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
"""White noise of the velocity, 1 mm/s in each sample; random walks of angle and velocity as of good sensors.

:meta hide-value:
"""

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


EFFECTS = ("nothing", "start", "gyro_bias", "gyro_delay", "accelerometer_delay", "size_effect")
"""What `left_out` plants: a start off by the table's roughness; 0.1 deg/h; 0.1 ms between gyros; 0.5 ms; 3 cm."""


def left_out(effects: Iterable[str] = EFFECTS) -> "DataFrame":
    """Errors that each effect outside of the fifteen parameters makes, alone and without noise.

    Parameters
    ----------
    effects : iterable of str, optional
        Any of `EFFECTS`. In all but "start" the attitudes at the start are the true ones. The iteration sets out from
        the truth, gyro biases excepted, which keeps the axes of the unit where the attitudes are meant.

    Returns
    -------
    DataFrame
        One row for each effect. For the paper's method and for the batch estimate: the largest error of a gyro's
        misalignment, arcsec, and of its scale factor, ppm, and of an accelerometer's bias, micro-g; for the paper's
        also chi-square with the noise of ``NOISE["walk"]``, of 18 degrees of freedom, which shows whether the residuals
        of one recording would tell.
    """
    import pandas as pd

    rows = {}
    for effect in effects:
        unit, motions = _planted(checks.option("effects", effect, EFFECTS))
        tests, truth = plan_of("paper"), Compensation.from_unit(unit)
        tables = record(unit, motions, RATE)
        starts = np.stack(
            [test.C_b_n if effect == "start" else m.C_b_n(0.0) for test, m in zip(tests, motions, strict=True)]
        )
        covariance = plan_covariance(tests, 1 / RATE, NOISE["walk"], scale_factors=True)
        known = {"initial_attitude": starts, "start": replace(truth, gyro_bias=np.zeros(3))}
        paper = calibrate(tables, tests, LATITUDE, noise=covariance, scale_factor="all", iterations=6, **known)
        whole = batch.estimate(tables, tests, LATITUDE, NOISE["walk"], **known)
        found = {}
        for method, result in (("paper", paper), ("batch", whole)):
            errors = differences(result.compensation, truth)
            for group, (names, unit_size) in _GROUPS.items():
                found[f"{method}_{group}"] = max(abs(errors[name]) for name in names) / unit_size
        rows[effect] = found | {"paper_chi_square": paper.solution.chi_square}
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("effect")


_GROUPS = {
    "misalignment_arcsec": ([f"m_g_{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3) if i != j], ARCSEC),
    "scale_factor_ppm": ([f"m_g_{i}{i}" for i in (1, 2, 3)], PPM),
    "bias_micro_g": ([f"b_a_{i}" for i in (1, 2, 3)], MICRO_G),
}


def _planted(effect: str) -> tuple[MeasurementUnit, tuple[TurnMotion, ...]]:
    """Unit with one effect, and how the table turns it; biases of gyros only where they are the effect."""
    rng = np.random.default_rng(2022)
    gyros = _sensors(rng, 0.0, RandomErrors())
    accelerometers = _sensors(rng, 1 * MILLI_G, RandomErrors())
    size = SizeEffect()
    if effect == "gyro_bias":
        gyros = replace(gyros, triad=replace(gyros.triad, bias=0.1 * DEG_PER_HOUR * np.array([1.0, -1.0, 1.0])))
    elif effect == "gyro_delay":
        gyros = replace(gyros, delay=(0.0, 1e-4, -1e-4))
    elif effect == "accelerometer_delay":
        accelerometers = replace(accelerometers, delay=(5e-4, 5e-4, 5e-4))
    elif effect == "size_effect":
        size = SizeEffect.one_point(0.03 * np.eye(3))
    unit = MeasurementUnit(gyros=gyros, accelerometers=accelerometers, size_effect=size)
    return unit, RoughTable.typical(LATITUDE, absorber=None).motions(plan_of("paper"), rng)


def _sensors(rng: np.random.Generator, bias: float, random: RandomErrors) -> Sensors:
    """Sensors with errors as from the factory: 5e-4 in scale and direction."""
    matrix = np.eye(3) + 5e-4 * rng.standard_normal((3, 3))
    return Sensors(triad=LinearTriad(bias=bias * rng.standard_normal(3), matrix=matrix), random=random)
