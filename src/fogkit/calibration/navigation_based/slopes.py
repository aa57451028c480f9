"""Slope of the computed velocity in a dwell, by least squares, and how sure it is.

**Which instant.** With a straight line the slope is the mean one, that of the middle of the dwell. If the tilt grows,
the slopes of the two dwells differ by its growth from middle to middle, though no error of (13) is there. With a
parabola the slope can be had at any instant. Here it is that in the middle of the turn, for both dwells: a tilt that
grows at a constant rate in n, as the Earth's rotation makes it of a wrong start, or as the bias of the gyro along the
axis of the turn does, then drops out of the difference. Biases of the two gyros across the axis turn with the unit and
stay in by half of the sum of their two rates times the duration of the turn. The Coriolis term, which follows the
velocity and so begins anew with it in each dwell, is taken out before a parabola is laid (`processing`): continued to
the turn it would be twice what was to be removed.

The price is noise: from dwells of 10 s to the middle of a turn of 15 s, ten times that of the mean slope. So a parabola
serves to see whether there is a growth (as the paper has it), and a straight line to calibrate.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SlopeFit:
    """Least-squares polynomial over given instants, of which one derivative is wanted.

    Attributes
    ----------
    basis : ndarray, shape (k, degree + 1)
        Orthonormal columns.
    weights : ndarray, shape (k,)
        The derivative is their product with the samples.
    """

    basis: Array
    weights: Array

    @classmethod
    def of(cls, times: ArrayLike, degree: int, instant: float | None = None, derivative: int = 1) -> Self:
        """Fit over `times`, shape (k,), s, of a derivative at an instant; by default in the middle of the times.

        Raises
        ------
        ValueError
            If there are less than ``degree + 2`` samples: without a further one the residuals say nothing.
        """
        times = checks.finite_array("times", times, ndim=1, min_size=degree + 2)
        middle = 0.5 * (times[0] + times[-1])
        scale = max(0.5 * (times[-1] - times[0]), np.finfo(float).tiny)
        instant = middle if instant is None else instant
        powers = np.vander((times - middle) / scale, degree + 1, increasing=True)
        basis, triangle = np.linalg.qr(powers)
        at = [
            np.polynomial.Polynomial.basis(i).deriv(derivative)((instant - middle) / scale) for i in range(degree + 1)
        ]
        weights = basis @ np.linalg.solve(triangle.T, np.array(at)) / scale**derivative
        return cls(basis, weights)

    def __call__(self, samples: Array) -> tuple[Array, Array]:
        """Derivatives, shape (..., channels), of samples, shape (..., k, channels), and their variances (24).

        The variances are true if samples have white noise; an angle random walk bends the velocity and is not seen.
        """
        residuals = samples - self.basis @ (self.basis.T @ samples)
        freedom = self.basis.shape[0] - self.basis.shape[1]
        variance = np.einsum("...kc,...kc->...c", residuals, residuals) * (self.weights @ self.weights / freedom)
        return self.weights @ samples, variance
