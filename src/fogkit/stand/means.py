"""From a recording to one mean reading per placement, with everything checked that can go wrong on the way.

Sums and differences of placements, such as the mean of four headings or half the difference of two turns, are
observations too: `Observations.combine` forms them, in readings and inputs alike.
"""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from numbers import Real
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.imu.tables import GYRO_COLUMNS, IMU_COLUMNS
from fogkit.noise import RandomErrors, mean_covariance
from fogkit.stand.laboratory import Laboratory
from fogkit.stand.placements import Placement, Schedule

if TYPE_CHECKING:
    from pandas import DataFrame

SAMPLING_TOLERANCE = 1e-3
"""Largest departure of a sample time from its mean, relative: jitter of a clock passes, a lost sample does not."""

CLIPPED_SHARE = 0.2
"""Share of samples at exactly the largest or smallest reading of a channel from which a channel counts as clipped."""

EDGE_OVER_NEXT = 2.5
"""How many times more samples a clipped channel has at its edge than at the next reading. Counted in pulses a sine, as
a tilted unit reads it on a turning table, has ``1 + sqrt(2)`` times more."""

EDGE_DEVIATIONS = 4.0
"""Standard deviations of its counts by which a channel counted in pulses must exceed `EDGE_OVER_NEXT`: where most
readings come more than once, that ratio may be chance."""

FEW_STEPS = 4
"""Different readings up to which a channel is one counted in pulses: it may stand at its edge without being clipped,
and its steps do not show that there is noise."""

ROUNDING = 1e-12
"""Scatter, of the largest reading of a channel, that is no noise."""


LARGE_RATE, LARGE_FORCE = 1e-3, 1.0
"""Inputs, rad/s and m/s^2, from which a channel shows how much it reads per unit of input."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Observations:
    """Mean readings, and the inputs that made them as far as the plan tells.

    Attributes
    ----------
    labels : tuple of str
        What each observation is.
    readings : ndarray, shape (n, 6)
        Mean readings of gyros x, y, z and accelerometers x, y, z.
    bias_share : ndarray, shape (n,)
        How much of a bias an observation holds: 1 for a mean, 0 for a difference.
    omega_ib_b, f_ib_b : ndarray, shape (n, 3)
        Expected inputs, rad/s and m/s^2.
    covariance : ndarray, shape (6, n, n), or None
        Covariance of the readings of each sensor; None if nothing is known of the noise.
    """

    labels: tuple[str, ...]
    readings: NDArray[np.float64]
    bias_share: NDArray[np.float64]
    omega_ib_b: NDArray[np.float64]
    f_ib_b: NDArray[np.float64]
    covariance: NDArray[np.float64] | None

    def combine(self, weights: ArrayLike, labels: Sequence[str]) -> "Observations":
        """Linear combinations of observations, shape (m, n) of weights, with names for them."""
        weights = checks.finite_array("weights", weights, shape=(None, len(self.labels)))
        if len(labels) != len(weights):
            raise ValueError(f"`labels` must be one for each row of `weights`, {len(weights)}, got {len(labels)}")
        return replace(
            self,
            labels=tuple(labels),
            readings=weights @ self.readings,
            bias_share=weights @ self.bias_share,
            omega_ib_b=weights @ self.omega_ib_b,
            f_ib_b=weights @ self.f_ib_b,
            covariance=None if self.covariance is None else weights @ self.covariance @ weights.T,
        )

    def joined(self, other: "Observations") -> "Observations":
        """Both, independent of each other."""
        n, m = len(self.labels), len(other.labels)
        covariance = None
        if self.covariance is not None and other.covariance is not None:
            covariance = np.zeros((6, n + m, n + m))
            covariance[:, :n, :n], covariance[:, n:, n:] = self.covariance, other.covariance
        names = ("readings", "bias_share", "omega_ib_b", "f_ib_b")
        both = {name: np.concatenate([getattr(self, name), getattr(other, name)]) for name in names}
        return replace(self, labels=self.labels + other.labels, covariance=covariance, **both)

    def to_frame(self) -> "DataFrame":
        """Table of the readings, index ``position``."""
        import pandas as pd

        return pd.DataFrame(self.readings, index=pd.Index(self.labels, name="position"), columns=list(IMU_COLUMNS))


def observations(
    recording: "DataFrame",
    schedule: Schedule,
    laboratory: Laboratory,
    *,
    random: tuple[RandomErrors, RandomErrors] | None = None,
    equivalents: ArrayLike = (1.0,) * 6,
) -> Observations:
    """Mean readings of each placement of a recording, with the inputs that the schedule says.

    Parameters
    ----------
    recording : pandas.DataFrame
        As from `Laboratory.record`: index ``time`` in s, columns ``gyro_x`` to ``accel_z`` and ``position``, with the
        labels of the schedule as text. Samples between placements may be there with a label of NaN.
    schedule : Schedule
        What was done.
    laboratory : Laboratory
        What is believed of the place: latitude, gravity, and errors known from elsewhere.
    random : tuple of RandomErrors, optional
        Random errors of gyros and accelerometers, in units of their input. The covariance of the means is then that of
        `fogkit.noise.mean_covariance`: a bias that wanders is followed through the whole recording, relative to the
        first sample. By default it follows from the scatter of the samples about what a steady turn makes of tilts and
        the Earth's rotation, taken as white; the standard deviations are then too small where a bias wanders.
    equivalents : array_like, shape (6,), optional
        Approximate readings per unit of input, gyros then accelerometers, for `random`; negative for an accelerometer
        that points backwards.

    Returns
    -------
    Observations
        One for each placement.

    Raises
    ------
    ValueError
        If a column or a position is missing, a position stands twice, readings are NaN, samples are lost, a channel is
        clipped or frozen, or the vertical axis of a position is another one than its label says. The message names the
        position and the channel. A channel with a few different readings only, as one counted in pulses has at low
        rates, is not called clipped: at the end of its range it cannot be told from a sound one.
    TypeError
        If a channel or the labels are of the wrong kind, or an argument is.

    Warns
    -----
    UserWarning
        If an accelerometer reads less with its axis up than down and `equivalents` do not say so: it points backwards,
        or all its positions were swapped, which readings cannot tell.
        If `random` is given and a channel reads less than half or more than twice what `equivalents` says.
    """
    checks.instance("schedule", schedule, Schedule)
    checks.instance("laboratory", laboratory, Laboratory)
    random = None if random is None else _both(random)
    pieces = _pieces(recording, schedule)
    for placement, piece in zip(schedule.placements, pieces, strict=True):
        _require_sound(placement, piece)
    _require_alive(schedule, pieces)
    readings = np.stack([piece[list(IMU_COLUMNS)].to_numpy().mean(axis=0) for piece in pieces])
    scale = checks.finite_array("equivalents", equivalents, shape=(6,))
    _require_vertical(schedule, readings[:, 3:], np.sign(scale[3:]))
    counts = np.array([len(piece) for piece in pieces])
    if random is None:
        scatter = np.stack([_scatter(*pair) for pair in zip(schedule.placements, pieces, strict=True)])
        largest = np.max([piece[list(IMU_COLUMNS)].abs().max() for piece in pieces], axis=0)
        variance = np.where(scatter > (ROUNDING * largest) ** 2, scatter, 0.0) / counts[:, None]
        covariance = np.stack([np.diag(column) for column in variance.T])
    else:
        start = np.array([piece.index[0] for piece in pieces])
        dt = float(np.mean(np.diff(pieces[0].index)))
        each = [mean_covariance(errors, start, start + counts * dt, dt) for errors in random]
        covariance = np.repeat(each, 3, axis=0) * scale[:, None, None] ** 2
    known = (np.diagonal(covariance, axis1=1, axis2=2) > 0).all()
    observed = with_inputs(readings, schedule, laboratory, covariance if known else None)
    if random is not None:
        _warn_of_equivalents(readings, np.hstack([observed.omega_ib_b, observed.f_ib_b]), scale)
    return observed


def with_inputs(
    readings: NDArray[np.float64],
    schedule: Schedule,
    laboratory: Laboratory,
    covariance: NDArray[np.float64] | None = None,
) -> Observations:
    """Observations of a schedule from its mean readings, shape (n, 6), with the inputs that it says.

    Parameters
    ----------
    readings : ndarray, shape (n, 6)
        Mean readings of gyros and accelerometers, one row for each placement.
    schedule, laboratory
        As in `observations`.
    covariance : ndarray, shape (6, n, n), optional
        Covariance of the readings of each sensor.

    Raises
    ------
    ValueError
        If there is not one row of finite readings for each placement.
    """
    omega, force = expected_inputs(schedule, laboratory)
    return Observations(
        labels=tuple(schedule.labels),
        readings=checks.finite_array("readings", readings, shape=(len(schedule), 6)),
        bias_share=np.ones(len(schedule)),
        omega_ib_b=omega,
        f_ib_b=force,
        covariance=covariance,
    )


def expected_inputs(schedule: Schedule, laboratory: Laboratory) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mean rate, rad/s, and specific force, m/s^2, along the unit's axes in each placement, each of shape (n, 3)."""
    inputs = [laboratory.mean_inputs(placement) for placement in schedule.placements]
    omega, force = (np.stack(part) for part in zip(*inputs, strict=True))
    return omega, force


def _both(random: tuple[RandomErrors, RandomErrors]) -> tuple[RandomErrors, RandomErrors]:
    """Random errors of gyros and accelerometers, checked."""
    if isinstance(random, RandomErrors):
        raise TypeError("`random` must be two RandomErrors, of gyros and of accelerometers, got one")
    gyros, accelerometers = random
    checks.instance("random[0]", gyros, RandomErrors)
    checks.instance("random[1]", accelerometers, RandomErrors)
    return gyros, accelerometers


def _pieces(recording: "DataFrame", schedule: Schedule) -> list["DataFrame"]:
    """The part of a recording that belongs to each placement."""
    checks.columns(recording, (*IMU_COLUMNS, "position"), name="recording")
    for name in IMU_COLUMNS:
        if recording[name].dtype.kind not in "iuf":
            raise TypeError(f"`recording[{name!r}]` must hold real numbers, got dtype {recording[name].dtype}")
    if "time" in recording.columns:
        raise ValueError("`recording` must have the time as index, got it as a column. `recording.set_index('time')`.")
    column = recording["position"].astype(object)
    labels = column.where(column.notna(), None).to_numpy()
    if labels.size and all(label is None or isinstance(label, Real) for label in labels):
        raise TypeError(
            "`recording['position']` must hold labels as text, got numbers. Read a file with "
            "`pd.read_csv(path, dtype={'position': str})`."
        )
    changes = np.flatnonzero(labels[1:] != labels[:-1]) + 1
    runs: dict[str, list[tuple[int, int]]] = {}
    for start, stop in zip([0, *changes], [*changes, len(labels)], strict=True):
        if start < stop and isinstance(labels[start], str):  # None between placements
            runs.setdefault(labels[start], []).append((start, stop))
    if missing := [label for label in schedule.labels if label not in runs]:
        raise ValueError(f"`recording` must hold every position of the schedule, got none of {_quoted(missing)}")
    if unknown := [label for label in runs if label not in schedule.labels]:
        raise ValueError(f"`recording` holds positions that are not in the schedule: {_quoted(unknown)}")
    if repeated := [label for label, parts in runs.items() if len(parts) > 1]:
        raise ValueError(
            f"`recording` must hold each position once and in one piece, got {_quoted(repeated)} repeatedly"
        )
    return [recording.iloc[slice(*runs[label][0])] for label in schedule.labels]


def _require_sound(placement: Placement, piece: "DataFrame") -> None:
    """Errors for a placement's samples that cannot be averaged."""
    where = f"position {placement.label!r}"
    values = piece[list(IMU_COLUMNS)].to_numpy(dtype=float)
    if len(piece) < 2:
        raise ValueError(f"{where} must have at least 2 samples, got {len(piece)}")
    for name, column in zip(IMU_COLUMNS, values.T, strict=True):
        if not np.isfinite(column).all():
            bad = int(np.flatnonzero(~np.isfinite(column))[0])
            raise ValueError(f"{where}: `{name}` must be finite, got {column[bad]} at {piece.index[bad]:g} s")
    steps = np.diff(piece.index.to_numpy(dtype=float))
    dt = float(np.median(steps))
    if not dt > 0 or (np.abs(steps - dt) > SAMPLING_TOLERANCE * dt).any():
        worst = int(np.argmax(np.abs(steps - dt)))
        raise ValueError(
            f"{where} must be sampled evenly, got a step of {steps[worst]:g} s at {piece.index[worst]:g} s among steps "
            f"of {dt:g} s. Resample, or split the position where samples were lost."
        )
    recorded = len(piece) * dt
    if abs(recorded - placement.duration) > max(0.01 * placement.duration, 1.5 * dt):
        raise ValueError(f"{where} must last {placement.duration:g} s, got {recorded:g} s of samples")


def _require_alive(schedule: Schedule, pieces: Sequence["DataFrame"]) -> None:
    """Errors for channels that are clipped, or frozen where readings at rest show that there is noise."""
    values = [piece[list(IMU_COLUMNS)].to_numpy(dtype=float) for piece in pieces]
    steps = np.zeros((len(pieces), len(IMU_COLUMNS)), dtype=int)
    for row, placement, columns in zip(steps, schedule.placements, values, strict=True):
        for channel, column in enumerate(columns.T):
            levels, counts = np.unique(column, return_counts=True)
            if levels[-1] - levels[0] <= ROUNDING * np.abs(levels).max():
                levels, counts = levels[:1], counts[:1]
            row[channel] = len(levels)
            edge = _clipped_at(levels, counts)
            if edge is not None:
                share = np.mean(column == edge)
                raise ValueError(
                    f"position {placement.label!r}: `{IMU_COLUMNS[channel]}` is clipped, {share:.0%} of its samples "
                    f"are {edge:.9g}"
                )
    still = [placement.rate == 0 for placement in schedule.placements]
    noisy = np.repeat((steps[still].reshape(-1, 2, 3) > FEW_STEPS).any(axis=(0, 2)), 3)
    for row, placement, columns in zip(steps, schedule.placements, values, strict=True):
        for channel in np.flatnonzero(noisy & (row == 1)):
            raise ValueError(
                f"position {placement.label!r}: `{IMU_COLUMNS[channel]}` is frozen at {columns[0, channel]:.9g} in all "
                f"{len(columns)} samples: a dead channel, or one beyond its range"
            )


def _clipped_at(levels: NDArray[np.float64], counts: NDArray[np.int_]) -> float | None:
    """Reading at which a channel is clipped, from its different readings and how often each came; None if it is not."""
    if len(levels) <= FEW_STEPS:
        return None
    for edge, beside in ((-1, -2), (0, 1)):
        chance = EDGE_DEVIATIONS * np.sqrt(counts[edge] + EDGE_OVER_NEXT**2 * counts[beside]) * (np.median(counts) > 1)
        if counts[edge] > max(CLIPPED_SHARE * counts.sum(), EDGE_OVER_NEXT * counts[beside] + chance):
            return levels[edge]
    return None


def _warn_of_equivalents(
    readings: NDArray[np.float64], inputs: NDArray[np.float64], scale: NDArray[np.float64]
) -> None:
    """``UserWarning`` if the readings per unit of input are not those given, where the inputs are large enough."""
    for name, reading, along, given in zip(IMU_COLUMNS, readings.T, inputs.T, scale, strict=True):
        along = along - along.mean()
        if np.abs(along).max() < (LARGE_RATE if name in GYRO_COLUMNS else LARGE_FORCE):
            continue
        found = float(along @ reading / (along @ along))
        if not 0.5 * abs(given) < abs(found) < 2 * abs(given):
            warnings.warn(
                f"`equivalents` has {given:.4g} for `{name}`, which reads some {found:.4g} per unit of input: the "
                "covariance from `random` is wrong by the square of their ratio",
                stacklevel=3,
            )


def _scatter(placement: Placement, piece: "DataFrame") -> NDArray[np.float64]:
    """Variance of the samples of each channel about a constant and, in a turn, a sine of the angle, shape (6,)."""
    values = piece[list(IMU_COLUMNS)].to_numpy(dtype=float)
    known = np.ones((len(values), 1))
    if placement.rate and len(values) > 3:
        angle = placement.rate * (piece.index.to_numpy(dtype=float) - piece.index[0])
        known = np.column_stack([known, np.cos(angle), np.sin(angle)])
    left, singular, _ = np.linalg.svd(known, full_matrices=False)
    left = left[:, singular > 1e-10 * singular[0]]  # a small part of a turn looks like a line
    rest = values - left @ (left.T @ values)
    return np.sum(rest**2, axis=0) / (len(values) - left.shape[1])


def _require_vertical(schedule: Schedule, accelerometers: NDArray[np.float64], signs: NDArray[np.float64]) -> None:
    """Error for a position whose upright axis is another one than its label says, where the readings tell."""
    vertical = [placement.vertical for placement in schedule.placements]
    for axis, name in enumerate("xyz"):
        if {(axis, 1), (axis, -1)} - set(vertical):
            continue  # the channel's range is not known from this schedule
        column = accelerometers[:, axis]
        middle, half = (column.max() + column.min()) / 2, (column.max() - column.min()) / 2
        shares = (column - middle) / (half or 1.0)
        up = np.mean([share for share, v in zip(shares, vertical, strict=True) if v == (axis, 1)])
        shares = shares if up >= 0 else -shares
        for placement, share, (upright, sign) in zip(schedule.placements, shares, vertical, strict=True):
            expected = sign if upright == axis else 0
            if abs(share - expected) > 0.5:
                word = {1: "up", -1: "down", 0: "level"}
                raise ValueError(
                    f"position {placement.label!r} has {name} {word[expected]} by its label, but `accel_{name}` reads "
                    f"{share:+.2f} of its span: {name} {word[int(np.clip(round(share), -1, 1))]}"
                )
        if up * signs[axis] < 0:
            labels = [p.label for p, v in zip(schedule.placements, vertical, strict=True) if v[0] == axis]
            warnings.warn(
                f"`accel_{name}` reads less with {name} up than with {name} down: it points backwards, or the "
                f"positions {_quoted(labels)} were swapped. Give its `equivalents` with the sign that it has.",
                stacklevel=3,
            )


def _quoted(labels: Sequence[str]) -> str:
    return ", ".join(map(repr, labels))
