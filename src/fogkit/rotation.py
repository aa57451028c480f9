"""Rotations as direction-cosine matrices, in the names of inertial navigation.

``C_b_n`` takes components in frame b to components in frame n: ``v_n = C_b_n @ v_b``. All functions broadcast over
leading axes: a vector has shape (..., 3), a matrix (..., 3, 3). Where `scipy.spatial.transform.Rotation` does the work,
it does it here too; added are the shapes, the frames and the angles of a vehicle.

**Body axes.** x to the right, y forward, z up: the axes that lie along east, north and up when the vehicle is level and
heads north, so that zero angles give the identity. Heading is clockwise from north seen from above, pitch is positive
nose-up, roll is positive right-side-down. From the level vehicle that heads north one turns by heading about -z, then
by pitch about the new x, then by roll about the newest y.

**Attitude error.** Its sign is fixed here, once, for the whole package::

    C_b_n_est = (I - skew(psi_n)) @ C_b_n        to first order in psi_n

as in [1]_, section 12.3.1. Turning the estimated attitude by ``psi_n`` makes it true (`small_angle_between`).
Groves [2]_ has the opposite sign.

References
----------
.. [1] D. H. Titterton, J. L. Weston, Strapdown inertial navigation technology, 2nd edition, IEE (2004).
.. [2] P. D. Groves, Principles of GNSS, inertial, and multisensor integrated navigation systems, 2nd edition (2013).
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from fogkit import checks

Array = NDArray[np.float64]

# Largest symmetric part, relative to the largest entry, of a matrix that still counts as skew: far above the rounding
# of a product of rotations, far below the second-order part that C1 @ C2.T - I has at angles of practical interest.
_SKEW_TOLERANCE = 1e-9


def skew(v: ArrayLike) -> Array:
    """Skew matrix of a vector: ``skew(a) @ b`` is the cross product of a and b.

    Parameters
    ----------
    v : array_like, shape (..., 3)
        Vector.

    Returns
    -------
    ndarray, shape (..., 3, 3)
        ``[[0, -z, y], [z, 0, -x], [-y, x, 0]]``, in the unit of `v`.

    Examples
    --------
    >>> skew([1.0, 2.0, 3.0]) @ np.array([1.0, 0.0, 0.0])
    array([ 0.,  3., -2.])
    """
    v = checks.finite_array("v", v, shape=(..., 3))
    return np.cross(v[..., np.newaxis, :], np.eye(3), axisa=-1, axisb=-1).swapaxes(-1, -2)


def vector(Omega: ArrayLike) -> Array:
    """Vector of a skew matrix: the inverse of `skew`.

    Parameters
    ----------
    Omega : array_like, shape (..., 3, 3)
        Skew matrix.

    Returns
    -------
    ndarray, shape (..., 3)
        Vector, in the unit of `Omega`.

    Raises
    ------
    ValueError
        If the symmetric part of a matrix exceeds 1e-9 of its largest entry. ``C_b_n_est @ C_b_n.T - I`` is such a
        matrix: it is skew only to first order; use `small_angle_between`.
    """
    Omega = checks.finite_array("Omega", Omega, shape=(..., 3, 3))
    symmetric = np.abs(Omega + np.swapaxes(Omega, -1, -2)).max(axis=(-2, -1)) / 2
    largest = np.abs(Omega).max(axis=(-2, -1))
    if (symmetric > _SKEW_TOLERANCE * largest).any():
        worst = (symmetric / np.where(largest > 0, largest, 1)).max()
        raise ValueError(
            f"`Omega` must be skew to {_SKEW_TOLERANCE:g} of its largest entry, got a symmetric part of {worst:.3g}. "
            "For the difference of two attitudes use `small_angle_between`."
        )
    antisymmetric = (Omega - np.swapaxes(Omega, -1, -2)) / 2
    return np.stack([antisymmetric[..., 2, 1], antisymmetric[..., 0, 2], antisymmetric[..., 1, 0]], axis=-1)


def dcm_from_rotvec(rotvec: ArrayLike) -> Array:
    """Matrix that turns vectors about an axis by an angle: the matrix exponential of ``skew(rotvec)``.

    Parameters
    ----------
    rotvec : array_like, shape (..., 3)
        Axis times angle, rad, right-handed; zero gives the identity.

    Returns
    -------
    ndarray, shape (..., 3, 3)
        Rotation matrix. If frame b comes from frame n by this turn, it is ``C_b_n``.

    Examples
    --------
    >>> dcm_from_rotvec([0.0, 0.0, np.pi / 2]).round(12) @ np.array([1.0, 0.0, 0.0])
    array([0., 1., 0.])
    """
    rotvec = checks.finite_array("rotvec", rotvec, shape=(..., 3))
    own = np.array(rotvec.reshape(-1, 3))  # SciPy takes none that cannot be written to
    return Rotation.from_rotvec(own).as_matrix().reshape(*rotvec.shape, 3)


def rotvec_from_dcm(C: ArrayLike) -> Array:
    """Rotation vector of a rotation matrix: the inverse of `dcm_from_rotvec`.

    Parameters
    ----------
    C : array_like, shape (..., 3, 3)
        Rotation matrix.

    Returns
    -------
    ndarray, shape (..., 3)
        Axis times angle, rad, the angle in [0, pi]. At pi both signs are right and one of them is returned.

    Raises
    ------
    ValueError
        If a matrix is not a rotation.
    """
    return _rotvec(checks.rotation_matrix("C", C))


def dcm_from_heading_pitch_roll(heading: ArrayLike, pitch: ArrayLike, roll: ArrayLike) -> Array:
    """Attitude of a vehicle, ``C_b_n``, from its angles; n is east-north-up, b is right-forward-up.

    Parameters
    ----------
    heading : array_like, shape (...,)
        Angle from north to the horizontal projection of the forward axis, clockwise seen from above, rad.
    pitch : array_like, shape (...,)
        Angle of the forward axis above the horizon, rad; meant in [-pi/2, pi/2].
    roll : array_like, shape (...,)
        Angle about the forward axis, rad, positive with the right side down.

    Returns
    -------
    ndarray, shape (..., 3, 3)
        ``C_b_n``; its columns are the right, forward and up axes in east-north-up components.

    Examples
    --------
    A vehicle that heads east has its right side to the south:

    >>> dcm_from_heading_pitch_roll(np.pi / 2, 0.0, 0.0).round(12) @ np.array([1.0, 0.0, 0.0])
    array([ 0., -1.,  0.])
    """
    angles = np.broadcast_arrays(
        -checks.finite_array("heading", heading),  # heading turns about -z
        checks.finite_array("pitch", pitch),
        checks.finite_array("roll", roll),
    )
    stacked = np.stack(angles, axis=-1)
    return Rotation.from_euler("ZXY", stacked.reshape(-1, 3)).as_matrix().reshape(*stacked.shape, 3)


def heading_pitch_roll_from_dcm(C_b_n: ArrayLike) -> tuple[Array, Array, Array]:
    """Heading, pitch and roll of an attitude: the inverse of `dcm_from_heading_pitch_roll`.

    Parameters
    ----------
    C_b_n : array_like, shape (..., 3, 3)
        Attitude; n is east-north-up, b is right-forward-up.

    Returns
    -------
    heading, pitch, roll : ndarray, shape (...,)
        Angles, rad, in [-pi, pi], [-pi/2, pi/2] and [-pi, pi].

    Raises
    ------
    ValueError
        If a matrix is not a rotation.

    Warns
    -----
    UserWarning
        If the forward axis is vertical to about 1e-7 rad. Only the sum or the difference of heading and roll is then
        defined; roll is set to zero and heading carries the rest.
    """
    C_b_n = checks.rotation_matrix("C_b_n", C_b_n)
    angles = Rotation.from_matrix(C_b_n.reshape(-1, 3, 3)).as_euler("ZXY").reshape(C_b_n.shape[:-1])
    heading, pitch, roll = np.moveaxis(angles * [-1.0, 1.0, 1.0], -1, 0)
    return heading, pitch, roll


def orthonormalise(C: ArrayLike) -> Array:
    """Rotation nearest to a matrix, in the least-squares sense over its entries.

    Parameters
    ----------
    C : array_like, shape (..., 3, 3)
        Matrix close to a rotation: rounded in a table, drifted in an integration, or with scale factors and skew axes.

    Returns
    -------
    ndarray, shape (..., 3, 3)
        Rotation matrix, ``U @ V.T`` of the singular value decomposition ``C = U @ diag(s) @ V.T``; it leaves no
        direction preferred, as orthogonalising row after row would.

    Raises
    ------
    ValueError
        If a matrix is singular (no rotation is nearest) or has a negative determinant (a reflection is nearer).

    Examples
    --------
    >>> orthonormalise([[0.0, -1.001, 0.0], [0.999, 0.0, 0.0], [0.0, 0.0, 1.0]]).round(12) + 0.0
    array([[ 0., -1.,  0.],
           [ 1.,  0.,  0.],
           [ 0.,  0.,  1.]])
    """
    C = checks.finite_array("C", C, shape=(..., 3, 3))
    U, s, Vt = np.linalg.svd(C)
    if (s[..., 2] <= 3 * np.finfo(float).eps * s[..., 0]).any():  # the rank test of np.linalg.matrix_rank
        raise ValueError(f"`C` must be regular, got a matrix with smallest singular value {s[..., 2].min():.3g}")
    if (np.linalg.det(C) < 0).any():
        worst = np.linalg.det(C).min()
        raise ValueError(f"`C` must have determinant > 0, got {worst:.3g}. Are both sets of axes right-handed?")
    return U @ Vt


def small_angle_between(C_b_n_est: ArrayLike, C_b_n: ArrayLike) -> Array:
    """Attitude error ``psi_n`` of an estimated attitude: the rotation vector that makes it true.

    Parameters
    ----------
    C_b_n_est : array_like, shape (..., 3, 3)
        Estimated attitude.
    C_b_n : array_like, shape (..., 3, 3)
        True attitude, or any other to compare with.

    Returns
    -------
    ndarray, shape (..., 3)
        ``psi_n``, rad, in the frame that both matrices lead to. ``C_b_n_est = (I - skew(psi_n)) @ C_b_n`` to first
        order, and ``dcm_from_rotvec(psi_n) @ C_b_n_est = C_b_n`` exactly, so large angles are right as well.

    Raises
    ------
    ValueError
        If a matrix is not a rotation.

    Examples
    --------
    An estimated heading that is 1 mrad too large (clockwise) has a positive error about up:

    >>> level = dcm_from_heading_pitch_roll(0.0, 0.0, 0.0)
    >>> small_angle_between(dcm_from_heading_pitch_roll(1e-3, 0.0, 0.0), level).round(9)
    array([0.   , 0.   , 0.001])
    """
    C_b_n_est = checks.rotation_matrix("C_b_n_est", C_b_n_est)
    C_b_n = checks.rotation_matrix("C_b_n", C_b_n)
    return _rotvec(C_b_n @ np.swapaxes(C_b_n_est, -1, -2))


def _rotvec(C: Array) -> Array:
    """Rotation vectors of matrices known to be rotations."""
    return Rotation.from_matrix(C.reshape(-1, 3, 3)).as_rotvec().reshape(C.shape[:-1])
