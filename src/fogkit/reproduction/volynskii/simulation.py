"""Motions simulated sample by sample and geometry by rotation matrices: what the statements in words come to."""

from __future__ import annotations

import numpy as np

from fogkit.calibration import requirements
from fogkit.earth import earth_rate_n
from fogkit.imu.constructions import TRIHEDRAL_ALPHA, TRIHEDRAL_BETA, block_rotation, pyramid_matrix
from fogkit.imu.errors import misalignment_matrix
from fogkit.reproduction.volynskii import instruments as paper
from fogkit.rotation import dcm_from_rotvec
from fogkit.units import DEG

ASSUMED_LATITUDE = 60 * DEG
"""Latitude of the table, rad: not stated; that of the authors' institute, rounded."""


def rocking_drift(
    positive: float, negative: float, *, known: tuple[float, float] | None = None, samples: int = 400_000
) -> float:
    """Mean error of a rocking gyro that reads true rate over its scale factor, rad/s.

    Parameters
    ----------
    positive, negative : float
        Scale factors, rate per reading, for positive and negative rate.
    known : tuple of float, optional
        The two scale factors that the user multiplies readings with; the mean one for both if not given.
    samples : int, optional
        Samples of one period of the paper's rocking.
    """
    rate = rocking_amplitude() * np.sin(2 * np.pi * (np.arange(samples) + 0.5) / samples)
    reading = rate / np.where(rate > 0, positive, negative)
    used = known or ((positive + negative) / 2,) * 2
    return float(np.mean(np.where(reading > 0, *used) * reading - rate))


def rocking_amplitude() -> float:
    """Amplitude of the rate of the paper's rocking, rad/s."""
    return float(requirements.rocking_rate_amplitude(paper.ROCKING_ANGLE, paper.ROCKING_PERIOD))


def turning_errors(scale_error: float, misalignment: float, rate: float, samples: int = 1000) -> np.ndarray:
    """Errors of a vertical and of a horizontal gyro along one turn, rad/s, shape (samples, 2).

    The vertical gyro has the scale error, the horizontal one leans upwards by the misalignment. The Earth rate is left
    out: at these errors its part is far below that of the turn.
    """
    heading = np.linspace(0, 2 * np.pi, samples)
    C_b_n = dcm_from_rotvec(heading[:, None] * [0, 0, 1.0])
    omega = np.einsum("nij,i->nj", C_b_n, [0, 0, rate])  # in body axes
    leaning = dcm_from_rotvec([0, -misalignment, 0]) @ [1, 0, 0]
    return np.stack([scale_error * omega[:, 2], omega @ leaning - omega[:, 0]], axis=-1)


def modulated_earth_rate(turns: float, samples: int = 100_000) -> float:
    """Mean Earth rate that a gyro across the axis of rotation reads over a number of turns about east, rad/s."""
    angle = 2 * np.pi * turns * (np.arange(samples) + 0.5) / samples
    _, north, up = earth_rate_n(ASSUMED_LATITUDE)
    return float(np.mean(north * np.cos(angle) + up * np.sin(angle)))


def second_approximation_error(angle: float) -> tuple[float, float]:
    """Largest relative error of a scale factor after (13) and after (16), all misalignments being +-`angle`, rad."""
    corners = angle * np.array(np.meshgrid(*[[-1, 1]] * 6)).reshape(6, -1).T
    A_g = misalignment_matrix(corners)
    diagonal = np.diagonal(A_g, axis1=1, axis2=2)
    first = 1 / diagonal  # M' = M / C_jj, by (11)
    cosines = A_g * first[..., None]  # C' of (14): row i times M'_i / M_i
    others = (cosines**2).sum(axis=-1) - np.diagonal(cosines, axis1=1, axis2=2) ** 2
    second = first * (1 - others / 2)
    return float(abs(first - 1).max()), float(abs(second - 1).max())


def rows_extend_to_rotations(angle: float) -> bool:
    """Whether each unit row of A_g extends to a rotation whose product with a rotation has the row of A_g's product."""
    A_g = misalignment_matrix(np.full(6, angle))
    C = dcm_from_rotvec([0.3, -0.2, 0.9])
    for i, row in enumerate(A_g):
        first = np.cross(row, [0, 0, 1]) if i != 2 else np.cross([0, 1, 0], row)
        first /= np.linalg.norm(first)
        triad = np.array([row, first, np.cross(row, first)])
        rotation = np.allclose(triad @ triad.T, np.eye(3), atol=1e-15)
        if not (rotation and np.allclose((triad @ C)[0], (A_g @ C)[i], atol=1e-15)):
            return False
    return True


def trihedral_directions(block_angle: float, tilt: float) -> np.ndarray:
    """Gyro axes of the trihedral, as rows in east-north-up, after a turn of the block and a tilt about east, rad."""
    axes = pyramid_matrix(TRIHEDRAL_ALPHA, TRIHEDRAL_BETA) @ block_rotation(block_angle)
    return axes @ dcm_from_rotvec([tilt, 0, 0]).T


def trihedral_brings_upright() -> dict[str, bool]:
    """Which gyro axis the tilt by ``90 deg - alpha_0`` and a turn of 0, 120 and 240 deg make vertical, as printed."""
    tilt = np.pi / 2 - TRIHEDRAL_ALPHA
    return {
        axis: bool(np.allclose(trihedral_directions(turn * DEG, tilt)["xyz".index(axis)], [0, 0, 1], atol=1e-14))
        for axis, turn in (("y", 0), ("x", 120), ("z", 240))
    }


def worst_azimuth_rate(azimuth: float) -> float:
    """Error of the Earth rate made by an azimuth error at the latitude where it is largest, rad/s."""
    lats = np.linspace(-np.pi / 2, np.pi / 2, 181)
    errors = requirements.earth_rate_error(np.array([0, 0, azimuth]), lats)
    return float(np.linalg.norm(errors, axis=-1).max())


def asymmetries() -> dict[str, float]:
    """Asymmetries of Table 2 by axis, by eq. (1)."""
    return {
        axis: float(requirements.asymmetry(paper.TABLE_2[f"{axis}+"]["mean"], paper.TABLE_2[f"{axis}-"]["mean"]))
        for axis in "xyz"
    }


def rocking_drifts_of_table_2() -> dict[str, float]:
    """Size of the drift that the asymmetries of Table 2 make under the paper's rocking if left alone, rad/s."""
    return {
        axis: abs(rocking_drift(paper.TABLE_2[f"{axis}+"]["mean"], paper.TABLE_2[f"{axis}-"]["mean"])) for axis in "xyz"
    }


def relative_spreads() -> dict[str, float]:
    """Spreads of Table 2 over the means: the relative spreads if the printed ones are in the unit of the means."""
    return {name: cell["spread"] / cell["mean"] for name, cell in paper.TABLE_2.items()}
