"""Calibration of gyros on a single-axis rate table: bias from positions, scale factor from a sequence of rates.

Each axis stands upright in turn and the table runs through a list of rates. The reading of the gyro along the axis
against the rate is one least-squares problem: scale factor, intercept, and what the scale factor does besides being
constant. The other two gyros tell their installation errors, at the rates from which one chooses to take them.
"""

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.calibration.multiposition import LinearCalibration, calibrate_gyros, require_same
from fogkit.estimation import Solution, linear
from fogkit.imu.triads import AXES
from fogkit.noise.processes import RandomErrors
from fogkit.results import contents
from fogkit.stand.laboratory import Laboratory
from fogkit.stand.means import Observations
from fogkit.stand.placements import Placement, Schedule

if TYPE_CHECKING:
    from pandas import DataFrame

SHAPES = {"asymmetry": lambda u: np.abs(u) / 2, "quadratic": lambda u: u**2, "cubic": lambda u: u**3}
"""Terms of the scale factor besides the constant one, as functions of the rate u (`fogkit.imu.unit.Shape`)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ScaleFactorFit:
    """Reading of one gyro against the rate along it.

    Attributes
    ----------
    axis : int
        0 to 2.
    rate : ndarray, shape (n,)
        Rates along the axis, rad/s, the rotation of the Earth included.
    reading : ndarray, shape (n,)
        Mean readings.
    terms : tuple of str
        Terms fitted besides scale factor and intercept, names of `SHAPES`.
    solution : Solution
        Parameters ``scale_factor``, ``intercept`` (the reading at rate zero) and, for each term, its coefficient times
        the scale factor.
    """

    axis: int
    rate: NDArray[np.float64]
    reading: NDArray[np.float64]
    terms: tuple[str, ...]
    solution: Solution

    @property
    def scale_factor(self) -> float:
        """Readings per rad/s."""
        return self.solution["scale_factor"]

    @property
    def scale_factor_deviation(self) -> float:
        """Standard deviation of the scale factor."""
        return float(self.solution.standard_deviation[0])

    @property
    def intercept(self) -> float:
        """Reading at rate zero, as a rate, rad/s."""
        return self.solution["intercept"] / self.scale_factor

    @property
    def intercept_deviation(self) -> float:
        """Standard deviation of the intercept, rad/s."""
        return self._ratio("intercept")[1]

    def coefficient(self, term: str) -> tuple[float, float]:
        """Coefficient of a term, as in `fogkit.imu.unit.Shape`, and its standard deviation.

        Raises
        ------
        ValueError
            If the term was not fitted.
        """
        checks.option("term", term, self.terms, fix="Name it in `terms` when fitting.")
        return self._ratio(term)

    @property
    def residual(self) -> NDArray[np.float64]:
        """Departure of each reading from the fit, as a rate, rad/s, shape (n,)."""
        return self.solution.residuals / self.scale_factor

    @property
    def nonlinearity(self) -> float:
        """Largest departure from the fit over the largest rate: IEEE 952's scale factor nonlinearity, of full scale."""
        return float(np.abs(self.residual).max() / np.abs(self.rate).max())

    def to_frame(self) -> "DataFrame":
        """Table of the points, index ``rate`` in rad/s: reading, residual in rad/s and relative to the rate."""
        import pandas as pd

        relative = np.divide(self.residual, self.rate, out=np.full_like(self.rate, np.nan), where=self.rate != 0)
        columns = {"reading": self.reading, "residual": self.residual, "relative residual": relative}
        return pd.DataFrame(columns, index=pd.Index(self.rate, name="rate"))

    def to_json(self) -> str:
        """Text that `from_json` turns into an equal result."""
        values = {"kind": type(self).__name__, "axis": self.axis, "terms": self.terms}
        arrays = {"rate": self.rate.tolist(), "reading": self.reading.tolist()}
        return json.dumps(values | arrays | {"solution": self.solution.to_json()})

    @classmethod
    def from_json(cls, text: str) -> "ScaleFactorFit":
        """Result from the text of `to_json`; ``ValueError`` if that was of another kind."""
        data = contents(text, cls.__name__)
        return cls(
            axis=data["axis"],
            rate=np.array(data["rate"]),
            reading=np.array(data["reading"]),
            terms=tuple(data["terms"]),
            solution=Solution.from_json(data["solution"]),
        )

    def _ratio(self, name: str) -> tuple[float, float]:
        """A parameter over the scale factor, with its standard deviation."""
        i = self.solution.index(name)
        value = float(self.solution.estimate[i] / self.scale_factor)
        slope = np.zeros(len(self.solution.names))
        slope[i], slope[0] = 1 / self.scale_factor, -value / self.scale_factor
        return value, float(np.sqrt(slope @ self.solution.covariance @ slope))


@dataclass(frozen=True, kw_only=True, eq=False)
class EastBias:
    """Biases of three gyros, each with its axis to the east.

    Attributes
    ----------
    solution : Solution
        Biases ``bias_x``, ``bias_y``, ``bias_z`` in units of the reading, with the covariance of noise and of what is
        known of the plate.
    """

    solution: Solution

    @property
    def bias(self) -> NDArray[np.float64]:
        """Biases, shape (3,), in units of the reading."""
        return self.solution.estimate

    @property
    def deviation(self) -> NDArray[np.float64]:
        """Their standard deviations, shape (3,)."""
        return self.solution.standard_deviation

    def to_frame(self) -> "DataFrame":
        """Table with the columns `estimate` and `standard_deviation`, index `name`, in units of the reading."""
        return self.solution.to_frame()

    def to_json(self) -> str:
        """Text that `from_json` turns into an equal result."""
        return json.dumps({"kind": type(self).__name__, "solution": self.solution.to_json()})

    @classmethod
    def from_json(cls, text: str) -> "EastBias":
        """Result from the text of `to_json`; ``ValueError`` if that was of another kind."""
        return cls(solution=Solution.from_json(contents(text, cls.__name__)["solution"]))


def fit_scale_factor(
    observed: Observations,
    schedule: Schedule,
    axis: int,
    *,
    terms: Iterable[str] = (),
    rate_error: float = 0.0,
    rates: Sequence[float] | None = None,
) -> ScaleFactorFit:
    """Scale factor, intercept and shape of one gyro from the rates about its axis.

    Parameters
    ----------
    observed : Observations
        One for each placement of the schedule.
    schedule : Schedule
        A rate sequence; only the placements with the axis up are used, at rest and turning.
    axis : int
        0 to 2.
    terms : iterable of str, optional
        Terms to fit besides scale factor and intercept: "asymmetry", "quadratic", "cubic".
    rate_error : float, optional
        Standard deviation of a rate of the table, relative to it; it joins the covariance of the readings. Without it
        the noise of the gyro alone weights the rates.
    rates : sequence of float, optional
        Commanded rates to use, rad/s; by default all.

    Returns
    -------
    ScaleFactorFit
        The rotation of the Earth along the axis counts as input, so that the intercept is the bias.

    Raises
    ------
    ValueError
        If a term is unknown, there are too few rates for what is to be fitted, or there is a rate error to weight
        against a noise that is not known.
    """
    require_same(observed, schedule)
    axis = _axis(axis)
    if isinstance(terms, str):
        raise TypeError(f"`terms` must be a sequence of names, got the text {terms!r}")
    terms = tuple(checks.option("terms", term, SHAPES) for term in terms)
    rate_error = checks.non_negative("rate_error", rate_error)
    chosen = [
        i
        for i, placement in enumerate(schedule.placements)
        if placement.vertical == (axis, 1) and (rates is None or np.isclose(placement.rate, rates, rtol=1e-9).any())
    ]
    there = [schedule.placements[i].rate for i in chosen]
    if absent := [rate for rate in (() if rates is None else rates) if not np.isclose(rate, there, rtol=1e-9).any()]:
        raise ValueError(
            f"`rates` must be rates of the schedule with {AXES[axis]} up, rad/s, got {absent[0]:.6g}. "
            "Multiply a rate in deg/s by `fogkit.units.DEG_PER_SECOND`."
        )
    needed = 2 + len(terms)
    distinct = {schedule.placements[i].rate for i in chosen}
    if len(distinct) < needed:
        raise ValueError(
            f"`schedule` must hold at least {needed} rates with {AXES[axis]} up to fit {needed} parameters, "
            f"got {len(distinct)}"
        )
    rate, reading = observed.omega_ib_b[chosen, axis], observed.readings[chosen, axis]
    design = np.column_stack([rate, np.ones_like(rate), *(SHAPES[term](rate) for term in terms)])
    covariance = None
    if observed.covariance is None and rate_error:
        raise ValueError("`rate_error` must be 0 where `observed` has no covariance to add it to. Give `random` there.")
    if observed.covariance is not None:
        first = np.polyfit(rate, reading, 1)[0]
        table = np.diag((first * rate_error * np.array([schedule.placements[i].rate for i in chosen])) ** 2)
        covariance = observed.covariance[axis][np.ix_(chosen, chosen)] + table
    names = ("scale_factor", "intercept", *terms)
    solution = linear(design, reading, covariance=covariance, names=names)
    return ScaleFactorFit(axis=axis, rate=rate, reading=reading, terms=terms, solution=solution)


def installation(observed: Observations, schedule: Schedule, *, rate: float = 150 * np.pi / 180) -> LinearCalibration:
    """Matrix of the gyros from turns of all three axes at one rate, both ways: the slides' installation errors.

    Parameters
    ----------
    observed : Observations
        One for each placement of the schedule.
    schedule : Schedule
        A rate sequence about x, y and z.
    rate : float, optional
        Size of the commanded rate to use, rad/s; by default the 150 deg/s of the slides.

    Returns
    -------
    LinearCalibration
        With biases from the same turns. The matrix, whose `LinearTriad.misalignment` are the installation errors,
        follows from the differences of opposite turns, as far as these weigh alike.

    Raises
    ------
    ValueError
        If the schedule does not hold the rate both ways about each axis.
    """
    require_same(observed, schedule)
    rate = checks.positive("rate", rate, "rad/s")
    chosen = [i for i, p in enumerate(schedule.placements) if np.isclose(abs(p.rate), rate, rtol=1e-9)]
    if not chosen:
        raise ValueError(f"`rate` must be one of the schedule's, got {rate:.6g} rad/s, {np.rad2deg(rate):.6g} deg/s")
    turned = {(p.vertical[0], p.vertical[1] * p.rate > 0) for p in (schedule.placements[i] for i in chosen)}
    missing = [f"{sign}{axis}" for j, axis in enumerate(AXES) for sign in "+-" if (j, sign == "+") not in turned]
    if missing:
        raise ValueError(
            f"`schedule` must hold the rate both ways about each axis, got no turn about {', '.join(missing)}"
        )
    return calibrate_gyros(observed.combine(np.eye(len(schedule))[chosen], [schedule.labels[i] for i in chosen]))


def bias_from_east(
    observed: Observations,
    schedule: Schedule,
    scale_factor: ArrayLike,
    laboratory: Laboratory,
    *,
    azimuth_deviation: float = 0.0,
    level_deviation: float = 0.0,
) -> EastBias:
    """Bias of each gyro from its readings with the axis to the east, where the Earth turns about neither.

    Parameters
    ----------
    observed : Observations
        One for each placement of the schedule.
    schedule : Schedule
        Positions at rest, at least one with each axis to the east; several of one axis are averaged by their weight.
    scale_factor : array_like, shape (3,)
        Readings per rad/s, for the expected inputs and their uncertainty.
    laboratory : Laboratory
        The place.
    azimuth_deviation, level_deviation : float, optional
        Standard deviations of the plate's azimuth and of its level about north, rad, common to all positions: an axis
        that points a little north or up reads that part of the Earth's rotation.

    Returns
    -------
    EastBias
        Biases and their covariance, of noise and plate.

    Raises
    ------
    ValueError
        If no position has an axis to the east, which the message names, or nothing is known of the noise.
    """
    require_same(observed, schedule)
    scale = checks.finite_array("scale_factor", scale_factor, shape=(3,))
    azimuth_deviation = checks.non_negative("azimuth_deviation", azimuth_deviation, "rad")
    level_deviation = checks.non_negative("level_deviation", level_deviation, "rad")
    rows = [
        (i, placement.axes.index("E"))
        for i, placement in enumerate(schedule.placements)
        if "E" in placement.axes and placement.rate == 0
    ]
    if missing := [AXES[j] for j in range(3) if j not in {axis for _, axis in rows}]:
        raise ValueError(
            f"`schedule` must hold a position with each axis to the east, got none of {', '.join(missing)}"
        )
    places, axes = (np.array(part) for part in zip(*rows, strict=True))
    reading = observed.readings[places, axes] - scale[axes] * observed.omega_ib_b[places, axes]
    design = np.eye(3)[axes]
    if observed.covariance is None:
        raise ValueError("`observed` must have a covariance: one position for each bias tells no noise. Give `random`.")
    _, north, up = laboratory.omega_ie_n
    shared = np.array([azimuth_deviation * north, level_deviation * up])[:, None] * scale[axes]
    same = axes[:, None] == axes  # the noise of different gyros is independent
    covariance = np.where(same, observed.covariance[axes[:, None], places[:, None], places], 0.0) + shared.T @ shared
    names = [f"bias_{axis}" for axis in AXES]
    return EastBias(solution=linear(design, reading, covariance=covariance, names=names))


@dataclass(frozen=True, kw_only=True)
class InstallationAccuracy:
    """What limits an installation error that is taken from a turn and its opposite at one rate.

    Attributes
    ----------
    rate : float
        Rate, rad/s.
    noise : float
        Standard deviation from the random errors of the gyro, rad.
    earth : float
        Largest error from the horizontal rotation of the Earth, over all headings, rad, if it is left out of the
        inputs.
    turns : float
        Turns of the table in the time of one reading.
    """

    rate: float
    noise: float
    earth: float
    turns: float


def installation_accuracy(
    rate: float, duration: float, random: RandomErrors, laboratory: Laboratory
) -> InstallationAccuracy:
    """What an installation error from a turn and its opposite is good to.

    Parameters
    ----------
    rate : float
        Rate, rad/s.
    duration : float
        Duration of each turn, s.
    random : RandomErrors
        Of the gyro, rad.
    laboratory : Laboratory
        The place.

    Returns
    -------
    InstallationAccuracy
        Noise ``sqrt(allan_variance(duration) / 2) / rate``, and the odd part of the mean horizontal rotation of the
        Earth over the turn, which is none for whole turns.
    """
    rate = checks.positive("rate", rate, "rad/s")
    duration = checks.positive("duration", duration, "s")
    horizontal = float(np.hypot(*laboratory.omega_ie_n[:2]))
    half = rate * duration / 2
    # over angles of +2h and -2h the mean of a horizontal vector is sinc(h) times the vector turned by -h and +h
    odd = abs(np.sinc(half / np.pi) * np.sin(half))
    return InstallationAccuracy(
        rate=rate,
        noise=float(np.sqrt(random.allan_variance(duration) / 2) / rate),
        earth=float(horizontal * odd / rate),
        turns=rate * duration / (2 * np.pi),
    )


def without_earth(observed: Observations, schedule: Schedule) -> Observations:
    """Same observations with the commanded rates alone as inputs, as a table without a known latitude has them.

    The Earth's vertical rate is then in the readings and not in the inputs. It cancels in half the difference of
    opposite turns, and so in a fit in which these weigh alike; other weights let a part of it into the matrix.
    """
    require_same(observed, schedule)
    omega = np.stack([_commanded(placement) for placement in schedule.placements])
    return replace(observed, omega_ib_b=omega)


def _commanded(placement: Placement) -> NDArray[np.float64]:
    axis, sign = placement.vertical
    return sign * placement.rate * np.eye(3)[axis]


def _axis(value: int) -> int:
    number = checks.integer("axis", value, minimum=0)
    if number > 2:
        raise ValueError(f"`axis` must be 0, 1 or 2, got {number}")
    return number
