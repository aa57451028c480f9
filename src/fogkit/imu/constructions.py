"""The three constructions of a measurement unit: how the nominal gyro axes stand in its case.

Frames of volynskii: 0 the case (X_0, Y_0 in the mounting plane, Z_0 upwards), B the gyro block, which may turn about
Z_B = Z_0, g1 the nominal gyro axes in the block.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fogkit import checks
from fogkit.rotation import dcm_from_rotvec

TRIHEDRAL_ALPHA = float(np.arctan(np.sqrt(0.5)))
TRIHEDRAL_BETA = np.pi / 4
"""Angles at which `pyramid_matrix` inclines its three axes equally to Z_B."""


def pyramid_matrix(alpha: ArrayLike, beta: ArrayLike) -> NDArray[np.float64]:
    """Direction cosines ``C_B_g1`` of the nominal gyro axes in the block.

    Parameters
    ----------
    alpha, beta : array_like, shape (...,)
        Angles alpha_0 and beta_0, rad.

    Returns
    -------
    ndarray, shape (..., 3, 3)
        The matrix B of volynskii eq. (3); a rotation for any angles.
    """
    sa, ca, sb, cb = np.sin(alpha), np.cos(alpha), np.sin(beta), np.cos(beta)
    zero = np.zeros_like(sa * sb)
    rows = [[cb + zero, -sb * sa, sb * ca], [zero, ca + zero, sa + zero], [-sb + zero, -cb * sa, cb * ca]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def block_rotation(angle: ArrayLike) -> NDArray[np.float64]:
    """Direction cosines ``C_0_B``, shape (..., 3, 3), of a block turned about Z_0 by `angle`, rad: volynskii (4)."""
    s, c = np.sin(angle), np.cos(angle)
    zero = np.zeros_like(s)
    rows = [[c, s, zero], [-s, c, zero], [zero, zero, zero + 1]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


@dataclass(frozen=True, kw_only=True)
class Construction:
    """A measurement unit's construction.

    Parameters
    ----------
    name : {"plain", "block", "trihedral"}
        Gyros along the axes of the case; the same on a block that turns about Z_0; or on a tilted trihedral that does.
    block_tilt : array_like, shape (2,), optional
        Small rotation about X_0 and Y_0 that brings the case's Z_0 onto the axis of the block, rad.

    Raises
    ------
    ValueError
        If the name is another one, or a construction without a block has a tilt of it.
    """

    name: str
    block_tilt: ArrayLike = field(default=(0.0, 0.0))

    def __post_init__(self) -> None:
        checks.option("name", self.name, ("plain", "block", "trihedral"))
        tilt = checks.finite_array("block_tilt", self.block_tilt, shape=(2,))
        object.__setattr__(self, "block_tilt", tuple(tilt.tolist()))
        if tilt.any() and not self.turns:
            raise ValueError(f"`block_tilt` must be 0 for the construction {self.name!r}, got {tilt.tolist()}")

    @property
    def turns(self) -> bool:
        """Whether the gyros stand on a block that turns."""
        return self.name != "plain"

    def C_0_g1(self, block_angle: float = 0.0) -> NDArray[np.float64]:
        """Nominal gyro axes in the case at an angle of the block, rad, shape (3, 3) (volynskii eq. (5)).

        Raises
        ------
        ValueError
            If the block of a construction that has none is turned.
        """
        if block_angle and not self.turns:
            raise ValueError(f"`block_angle` must be 0 for the construction {self.name!r}, got {block_angle}")
        C_B_g1 = pyramid_matrix(TRIHEDRAL_ALPHA, TRIHEDRAL_BETA) if self.name == "trihedral" else np.eye(3)
        tilted = dcm_from_rotvec([*self.block_tilt, 0.0]).T
        return C_B_g1 @ block_rotation(block_angle) @ tilted
