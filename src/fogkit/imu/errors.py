"""The error model of a gyro triad: bias, scale factors for either sign of the input, and the directions of its axes."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks

AXES = ("x", "y", "z")
MISALIGNMENTS = ("alpha_yx", "alpha_zx", "beta_xy", "beta_zy", "gamma_xz", "gamma_yz")
"""Angles of the input axes: first index the gyro, second the axis about which its input axis is turned."""


def misalignment_matrix(misalignments: ArrayLike, *, exact: bool = True) -> NDArray[np.float64]:
    """Directions of the three input axes from the six misalignment angles.

    Parameters
    ----------
    misalignments : array_like, shape (..., 6)
        Angles in the order of `MISALIGNMENTS`, rad, counter-clockwise seen from the positive end of the turn's axis.
    exact : bool, optional
        Whether the rows are made unit vectors. As printed they are shorter, by half the squared product of their
        angles.

    Returns
    -------
    ndarray, shape (..., 3, 3)
        ``A_g``: row j holds the input axis of gyro j in the nominal axes of the gyros (volynskii eq. (6)).

    Raises
    ------
    ValueError
        If the last axis is not of length 6, or an angle is not finite or not within a right angle.
    """
    angles = checks.finite_array("misalignments", misalignments, shape=(..., 6))
    if (np.abs(angles) >= np.pi / 2).any():
        raise ValueError(f"`misalignments` must be within a right angle, in rad, got {np.abs(angles).max():.6g}")
    s, c = np.sin(angles), np.cos(angles)
    a_yx, a_zx, b_xy, b_zy, g_xz, g_yz = range(6)
    A_g = np.empty((*angles.shape[:-1], 3, 3))
    A_g[..., 0, 0] = c[..., b_xy] * c[..., g_xz]
    A_g[..., 0, 1] = s[..., g_xz] * c[..., b_xy]
    A_g[..., 0, 2] = -s[..., b_xy] * c[..., g_xz]
    A_g[..., 1, 0] = -s[..., g_yz] * c[..., a_yx]
    A_g[..., 1, 1] = c[..., a_yx] * c[..., g_yz]
    A_g[..., 1, 2] = s[..., a_yx] * c[..., g_yz]
    A_g[..., 2, 0] = s[..., b_zy] * c[..., a_zx]
    A_g[..., 2, 1] = -s[..., a_zx] * c[..., b_zy]
    A_g[..., 2, 2] = c[..., a_zx] * c[..., b_zy]
    return A_g / np.linalg.norm(A_g, axis=-1, keepdims=True) if exact else A_g


def misalignments_from_matrix(A_g: ArrayLike) -> NDArray[np.float64]:
    """Six misalignment angles of the input axes, the inverse of `misalignment_matrix`.

    Parameters
    ----------
    A_g : array_like, shape (..., 3, 3)
        Directions of the input axes, of any length, each within a right angle of its nominal axis.

    Returns
    -------
    ndarray, shape (..., 6)
        Angles in the order of `MISALIGNMENTS`, rad.
    """
    A_g = checks.finite_array("A_g", A_g, shape=(..., 3, 3))
    # in each row of eq. (6) the ratio of an off-diagonal entry to the diagonal one is the tangent of one angle
    ratio = A_g / np.diagonal(A_g, axis1=-2, axis2=-1)[..., None]
    tangents = [
        ratio[..., 1, 2],
        -ratio[..., 2, 1],
        -ratio[..., 0, 2],
        ratio[..., 2, 0],
        ratio[..., 0, 1],
        -ratio[..., 1, 0],
    ]
    return np.arctan(np.stack(tangents, axis=-1))


def asymmetry(positive: ArrayLike, negative: ArrayLike) -> NDArray[np.float64]:
    """Scale factor asymmetry: difference of the scale factors for positive and negative input, over their mean.

    Parameters
    ----------
    positive, negative : array_like, shape (...,)
        Scale factors for positive and negative input, above zero, in the same unit.

    Returns
    -------
    ndarray, shape (...,)
        Asymmetry, pure number (volynskii eq. (1)).

    Raises
    ------
    ValueError
        If a scale factor is not positive and finite.

    Examples
    --------
    >>> print(f"{asymmetry(1.730345, 1.730357):.2e}")
    -6.94e-06
    """
    positive, negative = checks.finite_array("positive", positive), checks.finite_array("negative", negative)
    for name, values in (("positive", positive), ("negative", negative)):
        if (values <= 0).any():
            raise ValueError(f"`{name}` must be > 0, got {values.min()}")
    return (positive - negative) / ((positive + negative) / 2)


@dataclass(frozen=True, kw_only=True)
class GyroTriad:
    """Three gyros: what they read is ``bias + (A_g omega)_j / M_j``, with M_j by the sign of the input.

    Parameters
    ----------
    bias : array_like, shape (3,), optional
        Readings at rest in inertial space, in units of the reading.
    scale_positive, scale_negative : array_like, shape (3,), optional
        Scale factors M for positive and negative rate along the gyro's own input axis, rad/s per unit of the reading.
    misalignments : array_like, shape (6,), optional
        Angles in the order of `MISALIGNMENTS`, rad.
    angle_random_walk : float, optional
        Of each gyro, rad/sqrt(s); the two-sided spectral density of its rate noise is the square.
    bias_instability : float, optional
        Standard deviation of a bias that is constant during one reading and drawn anew for the next, rad/s.
    bias_drift : array_like, shape (3,), optional
        Change of the rate bias with time, as by a temperature that rises during the test, rad/s^2.

    Raises
    ------
    ValueError
        If a shape is wrong, a number not finite, a scale factor not positive, or a noise level negative.
    """

    bias: ArrayLike = field(default=(0.0, 0.0, 0.0))
    scale_positive: ArrayLike = field(default=(1.0, 1.0, 1.0))
    scale_negative: ArrayLike = field(default=(1.0, 1.0, 1.0))
    misalignments: ArrayLike = field(default=(0.0,) * 6)
    angle_random_walk: float = 0.0
    bias_instability: float = 0.0
    bias_drift: ArrayLike = field(default=(0.0, 0.0, 0.0))

    def __post_init__(self) -> None:
        for name in ("bias", "scale_positive", "scale_negative", "bias_drift"):
            values = checks.finite_array(name, getattr(self, name), shape=(3,))
            if name.startswith("scale") and (values <= 0).any():
                raise ValueError(f"`{name}` must be positive, in rad/s per unit of the reading, got {values.tolist()}")
            object.__setattr__(self, name, tuple(values.tolist()))
        angles = checks.finite_array("misalignments", self.misalignments, shape=(6,))
        object.__setattr__(self, "misalignments", tuple(angles.tolist()))
        for name in ("angle_random_walk", "bias_instability"):
            checks.non_negative(name, getattr(self, name))
        misalignment_matrix(self.misalignments)

    @property
    def A_g(self) -> NDArray[np.float64]:
        """Directions of the input axes in the nominal axes, shape (3, 3), unit rows."""
        return misalignment_matrix(self.misalignments)

    @property
    def asymmetry(self) -> NDArray[np.float64]:
        """Difference of the scale factors over their mean, shape (3,) (volynskii eq. (1))."""
        return asymmetry(self.scale_positive, self.scale_negative)
