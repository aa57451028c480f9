"""Calibration of three gyros and three accelerometers in positions: six, 24, or any, with turns where there are some.

Every observation is a mean reading, or a sum or difference of mean readings, whose input the plan tells
(`fogkit.stand.means`); every sensor has one least-squares problem, linear in its bias, the row of its matrix and, for
mechanical gyros, its acceleration sensitivity. The slides' closed forms are this fit for their plans.

Averaging the four headings of a position first (`average_positions`, the slides' step from N(24, 6) to F(6, 6)) makes
the horizontal rotation of the Earth and tilts of the plate drop out, so that north need not be known; differences of
turns (`turn_differences`) do the same for biases.
"""

import json
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fogkit import checks
from fogkit.estimation import Solution, linear
from fogkit.imu.tables import IMU_COLUMNS
from fogkit.imu.triads import AXES, LinearTriad
from fogkit.results import contents
from fogkit.stand.means import Observations
from fogkit.stand.placements import Schedule

if TYPE_CHECKING:
    from pandas import DataFrame

Weights = tuple[NDArray[np.float64], list[str]]

TERMS = ("bias", "matrix", "acceleration_sensitivity")

SMALLEST_COSINE = 0.5
"""Direction cosine of a sensor along its nominal axis below which a fit warns; axes on the edges of a cube that stands
on its corner have 0.577."""

ROUNDING = 1e-13
"""Part of the largest input below which an input counts as none."""


def parameter_names(sensor: int, terms: Sequence[str] = TERMS[:2]) -> tuple[str, ...]:
    """Names of the parameters of one sensor, 0 to 2: ``bias_x``, ``matrix_xx`` to ``matrix_xz``, and so on."""
    axis = AXES[sensor]
    groups = {term: [f"{term}_{axis}{other}" for other in AXES] for term in TERMS[1:]} | {"bias": [f"bias_{axis}"]}
    return tuple(name for term in terms for name in groups[term])


@dataclass(frozen=True, kw_only=True, eq=False)
class LinearCalibration:
    """Estimated bias, matrix and acceleration sensitivity of three sensors.

    Attributes
    ----------
    solutions : tuple of Solution
        The least-squares fit of each sensor: estimate, covariance, residuals, chi-square.
    """

    solutions: tuple[Solution, Solution, Solution]

    @property
    def triad(self) -> LinearTriad:
        """Sensors with the estimated parameters."""
        sensors = range(3)
        has_force = any("acceleration" in name for name in self.solutions[0].names)
        sensitivity = [self._part(j, "acceleration_sensitivity") for j in sensors] if has_force else np.zeros((3, 3))
        return LinearTriad(
            bias=[self._part(j, "bias")[0] for j in sensors],
            matrix=[self._part(j, "matrix") for j in sensors],
            acceleration_sensitivity=sensitivity,
        )

    @property
    def chi_square(self) -> float:
        """Sum over the sensors."""
        return sum(solution.chi_square for solution in self.solutions)

    @property
    def degrees_of_freedom(self) -> int:
        """Sum over the sensors."""
        return sum(solution.degrees_of_freedom for solution in self.solutions)

    @property
    def bias_deviation(self) -> NDArray[np.float64]:
        """Standard deviations of the biases, shape (3,), in units of the reading."""
        return np.array([np.sqrt(self._covariance(j, "bias")[0, 0]) for j in range(3)])

    @property
    def matrix_deviation(self) -> NDArray[np.float64]:
        """Standard deviations of the matrix, shape (3, 3)."""
        return np.array([np.sqrt(np.diagonal(self._covariance(j, "matrix"))) for j in range(3)])

    @property
    def equivalents_deviation(self) -> NDArray[np.float64]:
        """Standard deviations of the equivalents, shape (3,): of the lengths of the rows of the matrix."""
        cosines = self.triad.cosines
        return np.array([np.sqrt(c @ self._covariance(j, "matrix") @ c) for j, c in enumerate(cosines)])

    @property
    def cosines_deviation(self) -> NDArray[np.float64]:
        """Standard deviations of the direction cosines, shape (3, 3)."""
        triad, rows = self.triad, []
        for j, c in enumerate(triad.cosines):
            slope = (np.eye(3) - np.outer(c, c)) / triad.equivalents[j]
            rows.append(np.sqrt(np.diagonal(slope @ self._covariance(j, "matrix") @ slope.T)))
        return np.array(rows)

    @property
    def misalignment_deviation(self) -> NDArray[np.float64]:
        """Standard deviations of the misalignments, shape (3, 3), rad; zeros on the diagonal."""
        triad, rows = self.triad, []
        for j, row in enumerate(np.array(triad.matrix)):
            slope = (np.eye(3) - np.outer(row, np.eye(3)[j]) / row[j]) / row[j]
            rows.append(np.sqrt(np.diagonal(slope @ self._covariance(j, "matrix") @ slope.T)))
        return np.array(rows) * (1 - np.eye(3))

    @property
    def input_bias_deviation(self) -> NDArray[np.float64]:
        """Standard deviations of the biases as inputs, shape (3,)."""
        triad, deviations = self.triad, []
        for j, solution in enumerate(self.solutions):
            names = [f"bias_{AXES[j]}", f"matrix_{AXES[j]}{AXES[j]}"]
            index = [solution.index(name) for name in names]
            slope = np.array([1.0, -triad.input_bias[j]]) / triad.scale_factor[j]
            deviations.append(np.sqrt(slope @ solution.covariance[np.ix_(index, index)] @ slope))
        return np.array(deviations)

    def to_frame(self, form: str = "parameters") -> "DataFrame":
        """Table with the columns ``estimate`` and ``standard_deviation``, index ``parameter``, in SI units.

        Parameters
        ----------
        form : {"parameters", "slides", "standard"}, optional
            Bias and matrix as fitted; zero terms, equivalents and direction cosines; or bias as an input, scale factor
            and misalignment.
        """
        import pandas as pd

        rows = _FORMS[checks.option("form", form, _FORMS)](self)
        index = pd.Index([name for name, *_ in rows], name="parameter")
        return pd.DataFrame([row[1:] for row in rows], index=index, columns=["estimate", "standard_deviation"])

    def to_json(self) -> str:
        """Text that `from_json` turns into an equal result."""
        return json.dumps({"kind": type(self).__name__, "solutions": [s.to_json() for s in self.solutions]})

    @classmethod
    def from_json(cls, text: str) -> "LinearCalibration":
        """Result from the text of `to_json`; ``ValueError`` if that was of another kind."""
        return cls(solutions=tuple(map(Solution.from_json, contents(text, cls.__name__)["solutions"])))

    def _index(self, sensor: int, term: str) -> list[int]:
        names = self.solutions[sensor].names
        return [names.index(name) for name in parameter_names(sensor, (term,))]

    def _part(self, sensor: int, term: str) -> NDArray[np.float64]:
        return self.solutions[sensor].estimate[self._index(sensor, term)]

    def _covariance(self, sensor: int, term: str) -> NDArray[np.float64]:
        index = self._index(sensor, term)
        return self.solutions[sensor].covariance[np.ix_(index, index)]


def _as_fitted(calibration: LinearCalibration) -> list[tuple[str, float, float]]:
    return [
        row
        for solution in calibration.solutions
        for row in zip(solution.names, solution.estimate, solution.standard_deviation, strict=True)
    ]


def _in_slides(calibration: LinearCalibration) -> list[tuple[str, float, float]]:
    triad, rows = calibration.triad, []
    for j, axis in enumerate(AXES):
        rows.append((f"zero_{axis}", triad.bias[j], calibration.bias_deviation[j]))
        rows.append((f"equivalent_{axis}", triad.equivalents[j], calibration.equivalents_deviation[j]))
        for k, other in enumerate(AXES):
            rows.append((f"cosine_{axis}{other}", triad.cosines[j, k], calibration.cosines_deviation[j, k]))
    return rows + _sensitivities(calibration)


def _in_standard_terms(calibration: LinearCalibration) -> list[tuple[str, float, float]]:
    triad, rows = calibration.triad, []
    scale_deviation = np.diagonal(calibration.matrix_deviation)
    for j, axis in enumerate(AXES):
        rows.append((f"bias_{axis}", triad.input_bias[j], calibration.input_bias_deviation[j]))
        rows.append((f"scale_factor_{axis}", triad.scale_factor[j], scale_deviation[j]))
        for k, other in enumerate(AXES):
            if k != j:
                deviation = calibration.misalignment_deviation[j, k]
                rows.append((f"misalignment_{axis}{other}", triad.misalignment[j, k], deviation))
    return rows + _sensitivities(calibration)


def _sensitivities(calibration: LinearCalibration) -> list[tuple[str, float, float]]:
    return [row for row in _as_fitted(calibration) if row[0].startswith("acceleration_sensitivity")]


_FORMS = {"parameters": _as_fitted, "slides": _in_slides, "standard": _in_standard_terms}


def calibrate_accelerometers(observed: Observations) -> LinearCalibration:
    """Biases and matrix of three accelerometers, each from one least-squares fit.

    Parameters
    ----------
    observed : Observations
        Of positions whose specific forces span the three axes and leave the bias apart: the six positions, averaged 24
        points, or any. With a covariance chi-square tests the fit; without, the scatter of the residuals gives the
        noise.

    Returns
    -------
    LinearCalibration
        Readings per m/s^2 and in units of the reading.

    Raises
    ------
    ValueError
        If the positions leave a parameter open; the message names it.

    Warns
    -----
    UserWarning
        If a sensor reads along another axis rather than its own, as after a swap of columns.

    Examples
    --------
    A recording of a unit in six positions; from a file it would be
    ``pd.read_csv(path, index_col="time", dtype={"position": str})``:

    >>> from fogkit.imu.triads import LinearTriad
    >>> from fogkit.imu.unit import MeasurementUnit, Sensors
    >>> from fogkit.stand.laboratory import Laboratory
    >>> from fogkit.stand.means import observations
    >>> from fogkit.stand.placements import six_positions
    >>> planted = LinearTriad.from_standard(scale_factor=[1.001, 0.999, 1.0], input_bias=[0.01, -0.02, 0.0])
    >>> unit = MeasurementUnit(accelerometers=Sensors(triad=planted))
    >>> place, plan = Laboratory(latitude=0.8), six_positions()
    >>> recording = place.record(unit, plan, np.random.default_rng(1))
    >>> found = calibrate_accelerometers(observations(recording, plan, place)).triad
    >>> found.scale_factor.round(6), found.input_bias.round(6) + 0.0
    (array([1.001, 0.999, 1.   ]), array([ 0.01, -0.02,  0.  ]))
    """
    return _calibrate(observed, slice(3, 6), {"matrix": observed.f_ib_b})


def calibrate_gyros(observed: Observations, *, acceleration_sensitivity: bool = False) -> LinearCalibration:
    """Biases, matrix and, if wanted, acceleration sensitivity of three gyros, each from one least-squares fit.

    Parameters
    ----------
    observed : Observations
        Of positions and turns. Positions alone determine the matrix by the Earth's rotation only and, once averaged
        over the headings, not apart from an acceleration sensitivity; turns about the three axes do.
    acceleration_sensitivity : bool, optional
        Whether to estimate what the specific force does to mechanical gyros.

    Returns
    -------
    LinearCalibration
        Readings per rad/s, in units of the reading, and per m/s^2.

    Raises
    ------
    ValueError
        If the observations leave a parameter open; the message names it.

    Warns
    -----
    UserWarning
        If a sensor reads along another axis rather than its own, as after a swap of columns.
    """
    inputs = {"matrix": observed.omega_ib_b}
    if acceleration_sensitivity:
        inputs["acceleration_sensitivity"] = observed.f_ib_b
    return _calibrate(observed, slice(0, 3), inputs)


def _calibrate(observed: Observations, sensors: slice, inputs: Mapping[str, NDArray[np.float64]]) -> LinearCalibration:
    """The fit of the three sensors of one kind."""
    design = np.column_stack([observed.bias_share, *map(_beyond_rounding, inputs.values())])
    covariance = None if observed.covariance is None else observed.covariance[sensors]
    solutions = []
    for j, readings in enumerate(observed.readings[:, sensors].T):
        names = parameter_names(j, ("bias", *inputs))
        if covariance is None:  # a fit of too few observations would only say that they are too few for its noise
            linear(design, readings, standard_deviation=1.0, names=names).raise_if_unobservable("the plan")
        solution = linear(design, readings, covariance=None if covariance is None else covariance[j], names=names)
        solution.raise_if_unobservable("the plan")
        solutions.append(solution)
    result = LinearCalibration(solutions=tuple(solutions))
    for j, (axis, cosines) in enumerate(zip(AXES, result.triad.cosines, strict=True)):
        nearest = int(np.argmax(np.abs(cosines)))
        if abs(cosines[j]) < SMALLEST_COSINE:
            warnings.warn(
                f"`{IMU_COLUMNS[sensors][j]}` hardly reads along {axis}, direction cosine {cosines[j]:.3g}, but along "
                f"{AXES[nearest]}, {cosines[nearest]:.3g}: are channels swapped?",
                stacklevel=3,
            )
    return result


def _beyond_rounding(inputs: NDArray[np.float64]) -> NDArray[np.float64]:
    """Inputs, with 0 for what is rounding: a whole turn leaves 1e-17 of the Earth's level rotation, no information."""
    return np.where(np.abs(inputs) > ROUNDING * np.abs(inputs).max(), inputs, 0.0)


def average_positions(observed: Observations, schedule: Schedule) -> Observations:
    """Mean of all placements at rest with the same axis up or down, named ``x up``, ``x down`` and so on.

    Parameters
    ----------
    observed : Observations
        One for each placement of the schedule.
    schedule : Schedule
        What was done; turns in it are left out.

    Returns
    -------
    Observations
        One for each position, in the order in which they were taken first. All placements of a position weigh alike,
        whatever their durations: only so do the horizontal inputs cancel.
    """
    return _combined(observed, schedule, _averages)


def turn_differences(observed: Observations, schedule: Schedule) -> Observations:
    """Difference of each turn's integrated reading and that of the opposite turn, over the time of both.

    Free of biases if both last equally long: the slides' way to the gyros' equivalents. If not, the observation holds
    the share of the bias that is left, and the fit knows it.

    Parameters
    ----------
    observed : Observations
        One for each placement of the schedule.
    schedule : Schedule
        What was done; placements at rest are left out. Opposite turns have the same attitude and angle; their rates may
        differ.

    Returns
    -------
    Observations
        One for each pair, named after the turn in the positive direction.

    Raises
    ------
    ValueError
        If a turn has no opposite of the same attitude and angle; the message names it.
    """
    return _combined(observed, schedule, _differences)


def averages_and_differences(observed: Observations, schedule: Schedule) -> Observations:
    """Positions averaged over their headings, and differences of opposite turns: the slides' data for a whole unit.

    Parameters
    ----------
    observed, schedule
        As in `average_positions` and `turn_differences`, which it joins, with the covariance between both.
    """
    return _combined(observed, schedule, _averages, _differences)


def _combined(observed: Observations, schedule: Schedule, *ways: Callable[[Schedule], Weights]) -> Observations:
    """Combinations of observations by one or more ways to weight a schedule."""
    require_same(observed, schedule)
    parts = [way(schedule) for way in ways]
    return observed.combine(np.concatenate([w for w, _ in parts]), [name for _, names in parts for name in names])


def _averages(schedule: Schedule) -> Weights:
    """Weights and names of the means of positions."""
    groups: dict[tuple[int, int], list[int]] = {}
    for i, placement in enumerate(schedule.placements):
        if placement.rate == 0:
            groups.setdefault(placement.vertical, []).append(i)
    if not groups:
        raise ValueError("`schedule` must hold positions at rest to average, got turns only")
    weights = np.zeros((len(groups), len(schedule)))
    for row, members in zip(weights, groups.values(), strict=True):
        row[members] = 1 / len(members)
    labels = [f"{AXES[axis]} {'up' if sign > 0 else 'down'}" for axis, sign in groups]
    return weights, labels


def _differences(schedule: Schedule) -> Weights:
    """Weights and names of the differences of turns."""
    turning = [(i, p) for i, p in enumerate(schedule.placements) if p.rate]
    if not turning:
        raise ValueError("`schedule` must hold turns, got positions at rest only")
    turns: dict[tuple[str, float], list[int]] = {}
    for i, placement in turning:
        turns.setdefault((placement.axes, round(placement.turns, 6)), []).append(i)
    alone = [
        schedule.labels[i]
        for (axes, angle), members in turns.items()
        for i in members[len(turns.get((axes, -angle), [])) :]
    ]
    if alone:
        raise ValueError(f"`schedule` must hold the opposite of each turn, got none of {', '.join(map(repr, alone))}")
    pairs = [
        pair
        for (axes, angle), members in turns.items()
        if angle > 0
        for pair in zip(members, turns[axes, -angle], strict=True)
    ]
    durations = np.array([placement.duration for placement in schedule.placements])
    weights = np.zeros((len(pairs), len(schedule)))
    for row, (plus, minus) in zip(weights, pairs, strict=True):
        row[plus], row[minus] = durations[plus], -durations[minus]
        row /= durations[plus] + durations[minus]
    return weights, [schedule.labels[plus] for plus, _ in pairs]


def require_same(observed: Observations, schedule: Schedule) -> None:
    """``ValueError`` unless there is one observation for each placement, in the same order."""
    if list(observed.labels) != schedule.labels:
        raise ValueError(
            f"`observed` must hold one observation for each placement of `schedule`, {schedule.labels}, "
            f"got {list(observed.labels)}"
        )
