"""How far may the standard deviations (27) be believed? Closed forms of the nine tests, and what chi-square can see.

The three tests about an axis end where they began. So the changes of slope across the axis add up to the scale factor
of that gyro alone, and those along it to nothing: these three closures are all that is left over for a chi-square when
fifteen errors are fitted to eighteen changes. And the cells of table 1 hang together: with any diagonal R the scale
factor of a gyro follows from three other cells (`scale_factors_of_table_1`).

`judge` tells what happens to standard deviations and chi-square when the noise is not what it was taken for.
`batch_deviations` makes what is stored in ``data/derived/klimkovich_batch_deviations.csv``, and `noise_runs_again` what
is in ``data/derived/klimkovich_noise_runs_again.csv``.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.calibration import uncertainty
from fogkit.calibration.navigation_based import Compensation, batch
from fogkit.calibration.navigation_based.turn_model import PARAMETERS
from fogkit.calibration.velocity_noise import SensorNoise
from fogkit.campaign import map_cases
from fogkit.estimation.leastsquares import linear
from fogkit.noise import RandomErrors
from fogkit.reproduction.klimkovich import campaigns, paper, plan_search, tables
from fogkit.results import FrozenArrays
from fogkit.stand.turn_tests import TurnTest
from fogkit.units import DEG, DEG_PER_HOUR, PPM

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.float64]

TRIPLES = {
    "m_g_11": ("b_a_3", "b_a_2", "m_a_32"),
    "m_g_22": ("b_a_1", "b_a_3", "m_a_13"),
    "m_g_33": ("b_a_2", "b_a_1", "m_a_21"),
}
"""Scale factor of a gyro to the cells that fix its own: bias seen by the half turn, bias and angle by the quarters."""

_HALF_DIGIT = {"b": 5e-8, "m": 5e-3}  # of the printed cells, m/s^2 and arcsec


def closures() -> Array:
    """Combinations of the eighteen changes of slope that no error of calibration reaches, shape (3, 18).

    Returns
    -------
    ndarray
        For each block of three tests the sum of its changes along the axis of the turn: rows with three ones.
    """
    rows = np.zeros((3, 2 * paper.TESTS))
    for number, turn in enumerate(plan_search.recovered_plan()):
        rows[number // 3, 2 * number + (turn.along in "NS")] = 1
    return rows


def block_deviations(across: ArrayLike, turns: int = paper.TURNS) -> dict[str, float]:
    """Standard deviations of the three unknowns that the changes across the axis of one block share, in closed form.

    Parameters
    ----------
    across : array_like, shape (3,)
        Standard deviations of the changes of slope across the axis over gravity: quarter, half, quarter turn.
    turns : int, optional
        Whole turns n besides.

    Returns
    -------
    dict
        ``scale_factor`` of the gyro that turns; ``bias`` over gravity of the accelerometer that the half turn upends
        beside the axis; ``sum`` of another bias over gravity and a misalignment, which the quarter turns show.

    Notes
    -----
    With changes ``r1 = -b - c - a S``, ``r3 = 2 b - d S``, ``r5 = c - b - a S``, where ``a = (2 n + 1/2) pi`` and
    ``d = (2 n + 1) pi``: ``S = -(r1 + r3 + r5) / ((6 n + 2) pi)``, ``c = (r5 - r1) / 2`` and
    ``b = (r3 + d S) / 2``.
    """
    first, half, last = checks.finite_array("across", across, shape=(3,)) ** 2
    turns = checks.integer("turns", turns, minimum=0)
    share = (2 * turns + 1) / (2 * (6 * turns + 2))  # of each change that goes into b with the scale factor
    return {
        "scale_factor": float(np.sqrt(first + half + last) / ((6 * turns + 2) * np.pi)),
        "bias": float(np.sqrt((0.5 - share) ** 2 * half + share**2 * (first + last))),
        "sum": float(np.sqrt(first + last) / 2),
    }


def scale_factors_of_table_1(turns: int = paper.TURNS) -> "DataFrame":
    """Scale factor cells that follow from the other cells of table 1, whatever diagonal R they were computed with.

    Parameters
    ----------
    turns : int, optional
        Whole turns n of the tests.

    Returns
    -------
    DataFrame
        One row for each cell, ppm: ``printed``; ``follows``; and the range ``low`` to ``high`` that the rounding of the
        three other cells leaves. NaN where they contradict each other.

    Notes
    -----
    By `block_deviations`: the variance of the sum is that of g m less that of the other bias, which another block sees
    independently. It gives ``first + last``, the bias of the block then ``half``, and both the scale factor.
    """
    import pandas as pd

    rows = {}
    for name, cells in TRIPLES.items():
        values = [paper.TABLE_1[cell] for cell in cells]
        corners = [
            _scale_factor(
                *(
                    (value + sign * _HALF_DIGIT[cell[0]]) * tables.unit(cell)
                    for cell, value, sign in zip(cells, values, signs, strict=True)
                ),
                turns,
            )
            for signs in product((-1, 1), repeat=3)
        ]
        follows = _scale_factor(*(v * tables.unit(c) for c, v in zip(cells, values, strict=True)), turns)
        found = np.array([follows, min(corners), max(corners)]) / PPM  # monotonic in each cell over so short a range
        rows[name] = [paper.TABLE_1[name], *found]
    return pd.DataFrame.from_dict(rows, orient="index", columns=["printed", "follows", "low", "high"]).rename_axis(
        "parameter"
    )


def _scale_factor(bias: float, other_bias: float, angle: float, turns: int) -> float:
    """Standard deviation of a scale factor from those of the errors in its block."""
    share = (2 * turns + 1) / (2 * (6 * turns + 2))
    quarters = 4 * (angle**2 - other_bias**2)
    half = (bias**2 - share**2 * quarters) / (0.5 - share) ** 2
    total = quarters + half if min(quarters, half) >= 0 else np.nan
    return float(np.sqrt(total) / ((6 * turns + 2) * np.pi))


@dataclass(frozen=True, kw_only=True, eq=False)
class Judgement(FrozenArrays):
    """What a calibration says of itself when its noise is not what it was taken for.

    Attributes
    ----------
    names : tuple of str
        Parameters.
    stated, true : ndarray, shape (p,)
        Standard deviations of the estimates: with the noise assumed, and with the true one; rad and m/s^2.
    chi_square : ndarray, shape (draws,)
        Of the residuals, by draws of the true noise.
    degrees_of_freedom : int
        Of them.
    """

    names: tuple[str, ...]
    stated: Array
    true: Array
    chi_square: Array
    degrees_of_freedom: int

    @property
    def ratio(self) -> Array:
        """True over stated standard deviations, shape (p,)."""
        return self.true / self.stated

    def rejected(self, level: float = 0.05) -> float:
        """Share of calibrations whose chi-square exceeds what chance allows at a level."""
        from scipy.special import chdtri  # loaded where used

        level = checks.in_open_interval("level", level, 0, 1)
        return float(np.mean(self.chi_square > chdtri(self.degrees_of_freedom, level)))


def judge(
    plan: Sequence[TurnTest],
    assumed: SensorNoise,
    true: SensorNoise,
    *,
    rng: np.random.Generator,
    scale_factors: bool = True,
    dt: float = 0.01,
    draws: int = 20000,
) -> Judgement:
    """Standard deviations and chi-square of generalised least squares with one noise assumed and another at work.

    Parameters
    ----------
    plan : sequence of TurnTest
        Tests as commanded.
    assumed, true : SensorNoise
        Random errors of the sensors.
    rng : numpy.random.Generator
        Source of the draws.
    scale_factors, dt
        As in `fogkit.calibration.uncertainty.predict`.
    draws : int, optional
        Calibrations of which chi-square is drawn.

    Returns
    -------
    Judgement
        Exact standard deviations to first order; drawn chi-squares.

    Raises
    ------
    ValueError
        If a measurement has no assumed noise, or the plan leaves an error open.
    """
    rng = checks.generator("rng", rng)
    draws = checks.integer("draws", draws, minimum=1)
    solution = uncertainty.predict(plan, assumed, dt=dt, scale_factors=scale_factors)
    solution.raise_if_unobservable("the plan")
    rows = _design(plan, scale_factors)
    R, S = (uncertainty.plan_covariance(plan, dt, noise, scale_factors=scale_factors) for noise in (assumed, true))
    gain = solution.covariance @ np.linalg.solve(R, rows).T
    residual_maker = np.linalg.solve(np.linalg.cholesky(R), np.eye(len(rows)) - rows @ gain)
    return Judgement(
        names=solution.names,
        stated=solution.standard_deviation,
        true=np.sqrt(np.diagonal(gain @ S @ gain.T)),
        chi_square=_drawn_chi_square(residual_maker, S, rng, draws),
        degrees_of_freedom=solution.degrees_of_freedom,
    )


def judgements(
    plan: Sequence[TurnTest], assumed: SensorNoise, truths: Mapping[str, SensorNoise], *, rng: np.random.Generator
) -> "DataFrame":
    """Several true noises against one assumed.

    Parameters
    ----------
    plan, assumed, rng
        As in `judge`.
    truths : mapping of str to SensorNoise
        True noise by name.

    Returns
    -------
    DataFrame
        One row for each: largest and smallest ratio of true to stated standard deviation; mean chi-square and its
        degrees of freedom; share of rejections at the 5 % level, as it is and with the accelerometers' scale factors
        and vertical slopes left out (``rejected_level``).
    """
    import pandas as pd

    rows = {}
    for name, true in truths.items():
        found = judge(plan, assumed, true, rng=rng)
        level = judge(plan, assumed, true, rng=rng, scale_factors=False)
        rows[name] = {
            "smallest_ratio": found.ratio.min(),
            "largest_ratio": found.ratio.max(),
            "chi_square": found.chi_square.mean(),
            "degrees_of_freedom": found.degrees_of_freedom,
            "rejected": found.rejected(),
            "rejected_level": level.rejected(),
        }
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("true noise")


def _design(plan: Sequence[TurnTest], scale_factors: bool) -> Array:
    """Rows of the plan in the order of `uncertainty.plan_covariance`."""
    rows = np.stack([uncertainty.design(test, scale_factors=scale_factors) for test in plan])
    return np.concatenate([rows[:, first : first + 2].reshape(-1, rows.shape[-1]) for first in (0, 2)])


def _drawn_chi_square(residual_maker: Array, covariance: Array, rng: np.random.Generator, draws: int) -> Array:
    values, vectors = np.linalg.eigh(covariance)
    root = vectors * np.sqrt(np.maximum(values, 0))
    return np.sum((residual_maker @ root @ rng.standard_normal((len(root), draws))) ** 2, axis=0)


def swaying(frequency: ArrayLike, dwell: float, dt: float = 0.01) -> Array:
    """True standard deviation of a slope over that of (24), where the velocity sways with one frequency.

    Parameters
    ----------
    frequency : array_like, shape (...,)
        Hz, below half the rate of samples.
    dwell : float
        Duration of the dwell, s.
    dt : float, optional
        Time between samples, s.

    Returns
    -------
    ndarray, shape (...,)
        Root mean square over the phase of the sway. Above 1 the formula promises too much, below 1 too little: a line
        averages a fast sway better than white noise of the same power.
    """
    frequency = np.asarray(checks.finite_array("frequency", frequency))
    if not ((frequency > 0) & (frequency < 0.5 / dt)).all():
        raise ValueError(
            f"`frequency` must be between 0 and {0.5 / dt:g} Hz, got {frequency.min()} to {frequency.max()}"
        )
    count = round(checks.positive("dwell", dwell, "s") / checks.positive("dt", dt, "s"))
    weights = uncertainty.slope_weights(count, dt)
    wave = np.exp(2j * np.pi * frequency[..., None] * dt * np.arange(count))
    line = np.stack([np.ones(count), np.arange(count) - (count - 1) / 2]).T
    basis = line / np.linalg.norm(line, axis=0)
    residual = wave - (wave @ basis) @ basis.T
    scatter = np.sum(np.abs(residual) ** 2, axis=-1) / (count - 2)  # S^2 of (24), twice, as the slope below
    return np.abs(wave @ weights) / np.sqrt(scatter * (weights @ weights))


_KNOWN = {
    "b_g": 1e-3 * DEG_PER_HOUR,
    "start_up": 0.01 * DEG,
}  # as after a bias test; 3e-6 m/s^2 in a test by Earth's turn

BATCH_KINDS = {
    "changes of slope": None,
    "start attitudes known": ((), ("b_g",)),
    "start tilts": (("start",), ("b_g", "start_up")),
    "and headings": (("start",), ("b_g",)),
    "and gyro biases": (("start",), ()),
    "and centres": (("start", "centre"), ()),
    "and delays": (("start", "centre", "delay"), ()),
}
"""What `batch_deviations` compares: groups of states, and which of them are known to 0.001 deg/h and 0.01 deg."""


def batch_deviations(kinds: Sequence[str] = tuple(BATCH_KINDS)) -> "DataFrame":
    """Standard deviations by the paper's measurements with true weights, and by the batch estimate as it grows.

    ``batch_deviations().to_csv("data/derived/klimkovich_batch_deviations.csv", float_format="%.6e")`` takes a minute
    and writes the stored table.

    Parameters
    ----------
    kinds : sequence of str, optional
        Keys of `BATCH_KINDS`.

    Returns
    -------
    DataFrame
        Index: the errors of matrices and biases. Columns: kinds; rad, m/s^2, rad/s. The noise is ``NOISE["walk"]`` of
        `fogkit.reproduction.klimkovich.campaigns`, the recordings the nine tests without noise. "and delays" has all 59
        states.
    """
    import pandas as pd

    plan, noise = campaigns.plan_of("paper"), campaigns.NOISE["walk"]
    exact, starts = campaigns.inputs("walk", "paper")
    quiet = {name: replace(getattr(exact.unit, name), random=RandomErrors()) for name in ("gyros", "accelerometers")}
    recordings = replace(exact, unit=replace(exact.unit, **quiet)).record(None)
    truth = Compensation.from_unit(exact.unit)
    found = {}
    for kind in kinds:
        checks.option("kinds", kind, tuple(BATCH_KINDS))
        if BATCH_KINDS[kind] is None:
            solution = uncertainty.predict(plan, noise, scale_factors=True)
        else:
            groups, known = BATCH_KINDS[kind]
            solution = batch.estimate(
                recordings,
                plan,
                campaigns.LATITUDE,
                noise,
                start=truth,
                initial_attitude=starts,
                groups=groups,
                prior={name: _KNOWN[name] for name in known},
            ).solution
        found[kind] = dict(zip(solution.names, solution.standard_deviation.tolist(), strict=True))
    return pd.DataFrame(found).reindex(batch.TRIADS).rename_axis("state")


def noise_runs_again(seeds: Iterable[int] = range(600, 1200), *, progress: bool | str = False) -> "DataFrame":
    """The runs of `campaigns.noise_runs` with random walks, the paper's plan and true weights, with other seeds.

    ``noise_runs_again().to_csv("data/derived/klimkovich_noise_runs_again.csv", index=False, float_format="%.6f")``
    takes minutes and writes the stored table. The mean NEES of the first 600 lies outside of its 95 % interval; these
    tell whether by chance.

    Parameters
    ----------
    seeds : iterable of int, optional
        Seeds of the runs.
    progress
        As in `fogkit.campaign.map_cases`.

    Returns
    -------
    DataFrame
        One row for each run, columns as `campaigns.noise_run` gives them.
    """
    import pandas as pd

    cases = [{"seed": seed, "case": "walk", "plan": "paper", "weights": "noise"} for seed in seeds]
    return pd.DataFrame(map_cases(campaigns.noise_run, cases, progress=progress))


def closure_chi_square(changes: ArrayLike, deviations: ArrayLike) -> float:
    """Chi-square of eighteen changes of slope with a diagonal R, by the three closures alone.

    Parameters
    ----------
    changes, deviations : array_like, shape (18,)
        Changes of slope and their standard deviations, m/s^2.

    Returns
    -------
    float
        The same as of the residuals of all fifteen errors fitted to the changes.
    """
    changes = checks.finite_array("changes", changes, shape=(2 * paper.TESTS,))
    deviations = checks.finite_array("deviations", deviations, shape=(2 * paper.TESTS,))
    rows = closures()
    return float(np.sum((rows @ changes) ** 2 / (rows @ deviations**2)))


def fitted_chi_square(changes: ArrayLike, deviations: ArrayLike) -> float:
    """The same by a fit of the fifteen errors of (13)."""
    H = plan_search.measurement_matrix()
    return linear(H, changes, standard_deviation=deviations, names=PARAMETERS).chi_square
