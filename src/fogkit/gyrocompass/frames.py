"""Frames of the gyrocompass: geographic, hull, mount, pyramid of gyros; and the one way from them to the package's.

All four are right-handed and have their second axis upright when the vehicle is level:

=============  ======  =====================================================================================
frame          letter  axes
=============  ======  =====================================================================================
geographic     g       north, up, east
hull           h       forward, up, starboard
mount          m       those of the hull, turned about the hull's up axis by the angle of the mount
pyramid        p       input axes of the three gyros, normal to the faces of a pyramid round the mount's up axis
=============  ======  =====================================================================================

Heading is clockwise from north, trim is positive with the bow up, roll with the starboard side down; the angle of the
mount is counter-clockwise seen from above, so that the mount's own heading is that of the hull less the angle. Names of
matrices are as everywhere, ``C_h_g`` takes hull components to geographic ones; the thesis prints the inverses,
``A_gamma A_theta A_K = C_h_g.T``, ``A_beta = C_m_h.T``, ``A_e = C_p_m.T``.

References
----------
.. [1] Le Van Chang, Gyrocompass with a quasi-harmonic autocompensating mount (in Russian), thesis abstract, LETI,
   St Petersburg, 2015, chapter 2.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from fogkit import checks

Array = NDArray[np.float64]

TO_PACKAGE = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
"""Matrix from (north, up, east) to (east, north, up), and as well from (forward, up, starboard) to the package's body
axes (right, forward, up): ``v_n = TO_PACKAGE @ v_g``, ``v_b = TO_PACKAGE @ v_h``."""
TO_PACKAGE.setflags(write=False)

PYRAMID_ANGLES = (np.pi, float(np.arctan(np.sqrt(2))), np.pi / 4)
"""Euler angles of the pyramid, rad; [1]_ prints 180, 54.7 and 45 degrees."""

PYRAMID_AXES = "YZY"
"""Axes of the three turns, each in the axes as turned so far. [1]_ names the angles, not the axes: see
`fogkit.reproduction.lechang.pyramid` for the search that leaves this sequence only."""


def package_attitude(C_h_g: ArrayLike) -> Array:
    """Attitude of the package, ``C_b_n``, for one of the hull against north-up-east.

    Parameters
    ----------
    C_h_g : array_like, shape (..., 3, 3)
        Attitude of the hull (forward, up, starboard) against (north, up, east).

    Returns
    -------
    ndarray, shape (..., 3, 3)
        ``C_b_n`` of (right, forward, up) against (east, north, up). Heading, trim and roll of the one are heading,
        pitch and roll of the other (`fogkit.rotation.dcm_from_heading_pitch_roll`).

    Raises
    ------
    ValueError
        If a matrix is not a rotation.
    """
    return TO_PACKAGE @ checks.rotation_matrix("C_h_g", C_h_g) @ TO_PACKAGE.T


def hull_attitude(heading: ArrayLike, trim: ArrayLike, roll: ArrayLike) -> Array:
    """Attitude of the hull, ``C_h_g``, from its angles: turns by heading about down, trim, then roll.

    Parameters
    ----------
    heading, trim, roll : array_like, shape (...,)
        Angles, rad: clockwise from north, bow up, starboard down.

    Returns
    -------
    ndarray, shape (..., 3, 3)
        ``C_h_g``; its columns are forward, up and starboard in north-up-east components.

    Examples
    --------
    A hull that heads east has its bow in the east and its starboard side in the south:

    >>> hull_attitude(np.pi / 2, 0.0, 0.0).round(12).T[[0, 2]] + 0.0
    array([[ 0.,  0.,  1.],
           [-1.,  0.,  0.]])
    """
    angles = np.broadcast_arrays(
        -checks.finite_array("heading", heading), checks.finite_array("trim", trim), checks.finite_array("roll", roll)
    )
    return _turns("YZX", np.stack(angles, axis=-1))


def heading_trim_roll(C_h_g: ArrayLike) -> tuple[Array, Array, Array]:
    """Heading, trim and roll of the hull: the inverse of `hull_attitude`.

    Parameters
    ----------
    C_h_g : array_like, shape (..., 3, 3)
        Attitude of the hull.

    Returns
    -------
    heading, trim, roll : ndarray, shape (...,)
        Angles, rad, in [-pi, pi], [-pi/2, pi/2] and [-pi, pi].

    Raises
    ------
    ValueError
        If a matrix is not a rotation.

    Warns
    -----
    UserWarning
        If the bow points up or down to about 1e-7 rad: heading and roll are then not defined apart.
    """
    C_h_g = checks.rotation_matrix("C_h_g", C_h_g)
    angles = Rotation.from_matrix(C_h_g.reshape(-1, 3, 3)).as_euler("YZX").reshape(C_h_g.shape[:-1])
    heading, trim, roll = np.moveaxis(angles * [-1.0, 1.0, 1.0], -1, 0)
    return heading, trim, roll


def mount_attitude(angle: ArrayLike) -> Array:
    """Matrix ``C_m_h`` of a mount turned against the hull about the hull's up axis.

    Parameters
    ----------
    angle : array_like, shape (...,)
        Angle of the mount, rad, counter-clockwise seen from above.

    Returns
    -------
    ndarray, shape (..., 3, 3)
        ``C_m_h``; the inverse of the matrix of the angle in (3) of [1]_.
    """
    angle = checks.finite_array("angle", angle)
    return _turns("Y", angle[..., np.newaxis])


def pyramid_axes(angles: ArrayLike = PYRAMID_ANGLES, sequence: str = PYRAMID_AXES) -> Array:
    """Matrix ``C_p_m`` of the gyros' input axes in the mount, from a sequence of three Euler turns.

    Parameters
    ----------
    angles : array_like, shape (3,), optional
        Turns, rad, each about an axis as the turns before left it.
    sequence : str, optional
        Axes of the turns, three of ``XYZ``.

    Returns
    -------
    ndarray, shape (3, 3)
        ``C_p_m``; column j is the input axis of gyro j in mount components (forward, up, starboard at angle zero).
        With the defaults each gyro has ``1/sqrt(3)`` of a rate about the mount's axis, and gyro y no starboard part.

    Examples
    --------
    >>> (np.sqrt(6) * pyramid_axes()).round(12)[:, 1] ** 2  # gyro y: sqrt(2/3) forward, 1/sqrt(3) up
    array([4., 2., 0.])
    """
    angles = checks.finite_array("angles", angles, shape=(3,))
    if not isinstance(sequence, str) or len(sequence) != 3 or set(sequence) - set("XYZ"):
        raise ValueError(f"`sequence` must be three letters of XYZ, got {sequence!r}")
    if sequence[0] == sequence[1] or sequence[1] == sequence[2]:
        raise ValueError(f"`sequence` must not name an axis twice running: two turns make one there, got {sequence!r}")
    return _turns(sequence, angles)


def _turns(sequence: str, angles: Array) -> Array:
    """Matrices of successive turns about the newest axes, shape (..., 3, 3)."""
    C = Rotation.from_euler(sequence, angles.reshape(-1, len(sequence))).as_matrix()
    return C.reshape(*angles.shape[:-1], 3, 3)
