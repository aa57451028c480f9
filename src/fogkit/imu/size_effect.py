"""Size effect: three accelerometers do not sit in one point, so a turn reads as acceleration.

An accelerometer has one centre at best. A pendulum whose moments of inertia do not match has two, the effective centres
of mass for angular velocity and for angular acceleration ([1]_, anisoinertia): an axis of constant rate, or one of
angular acceleration, that passes through them makes no reading.

References
----------
.. [1] IEEE Std 528-2019, IEEE standard for inertial sensor terminology.
"""

from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks

AT_REFERENCE = ((0.0,) * 3,) * 3
LARGEST = 1.0
"""Largest distance of a centre from the reference point, m: more is likely to be in mm."""


@dataclass(frozen=True, kw_only=True)
class SizeEffect:
    """Where the accelerometers feel a turn, in body axes from the reference point of the unit.

    Accelerometer i with the input axis e_i feels ``e_i . (f + alpha x a_i + omega x (omega x v_i))``, where a_i and v_i
    are its centres for angular acceleration and for angular velocity, omega the rate against inertial space and alpha
    its derivative.

    Parameters
    ----------
    acceleration_centres : array_like, shape (3, 3), optional
        Row i: centre of accelerometer i for angular acceleration, m.
    velocity_centres : array_like, shape (3, 3), optional
        Row i: its centre for angular velocity, m; those for angular acceleration if not given, the model of one point.

    Raises
    ------
    ValueError
        If a shape is wrong, a number not finite, or a distance beyond `LARGEST`.

    Notes
    -----
    klimkovich counts 9 parameters of one point and 18 of two, 0.3 to 3 cm apart, and refers to IEEE 1293 for the
    second. For one point the formula is that of a rigid body in uniform gravity, exact. With the centre for angular
    velocity by d along the pendulum from that for angular acceleration the reading grows by d times the product of the
    rates about the input axis and about the pendulum: the offset that [1]_ describes, with the same proportion.
    Three of the 18 numbers have no effect: those of the centres for angular acceleration along the input axes.
    """

    acceleration_centres: ArrayLike = field(default=AT_REFERENCE)
    velocity_centres: ArrayLike | None = None

    def __post_init__(self) -> None:
        if self.velocity_centres is None:
            object.__setattr__(self, "velocity_centres", self.acceleration_centres)
        for name in ("acceleration_centres", "velocity_centres"):
            centres = checks.finite_array(name, getattr(self, name), shape=(3, 3))
            fix = "Multiply millimetres by 1e-3."
            checks.array_in_closed_interval(name, centres, -LARGEST, LARGEST, "m", fix=fix)
            object.__setattr__(self, name, tuple(map(tuple, centres.tolist())))

    @classmethod
    def one_point(cls, centres: ArrayLike) -> Self:
        """Model of 9 parameters: row i is the one centre of accelerometer i, m, shape (3, 3)."""
        return cls(acceleration_centres=centres)

    @property
    def is_zero(self) -> bool:
        """Whether all centres are in the reference point."""
        return not (np.any(self.acceleration_centres) or np.any(self.velocity_centres))

    @property
    def parameters(self) -> int:
        """Parameters of the model: 9 for one point, 18 for two."""
        return 9 if self.acceleration_centres == self.velocity_centres else 18

    def added_force(self, alpha: ArrayLike, omega_products: ArrayLike) -> NDArray[np.float64]:
        """What each accelerometer feels more than the reference point.

        Parameters
        ----------
        alpha : array_like, shape (..., 3)
            Derivative of the rate, rad/s^2, body axes; or its integral over a step, the change of the rate, rad/s.
        omega_products : array_like, shape (..., 3, 3)
            Products of the rates, ``omega_j omega_k``, rad^2/s^2; or their integrals, rad^2/s.

        Returns
        -------
        ndarray, shape (..., 3, 3)
            Row i: vector at accelerometer i, m/s^2; or m/s.
        """
        alpha = checks.finite_array("alpha", alpha, shape=(..., 3))
        products = checks.finite_array("omega_products", omega_products, shape=(..., 3, 3))
        spin = products - np.trace(products, axis1=-2, axis2=-1)[..., None, None] * np.eye(3)
        # omega x (omega x r) = (omega omega^T - |omega|^2 I) r
        by_velocity = np.array(self.velocity_centres) @ spin  # symmetric
        return np.cross(alpha[..., None, :], np.array(self.acceleration_centres)) + by_velocity
