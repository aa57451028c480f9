"""``north``: where is it, by gyros at rest at several angles of a mount?"""

from argparse import Namespace

import numpy as np
from numpy.typing import NDArray

from fogkit.cli.loading import load
from fogkit.cli.placed_calibrations import residual_finding
from fogkit.cli.results import Estimates, Result, table_of
from fogkit.constants import EARTH_RATE
from fogkit.estimation import Solution, linear
from fogkit.imu.tables import GYRO_COLUMNS
from fogkit.io.errors import RecordingError
from fogkit.io.handover import dwell_means
from fogkit.io.verdicts import Finding
from fogkit.rotation import dcm_from_rotvec
from fogkit.stand.placements import attitude
from fogkit.units import DEG

Array = NDArray[np.float64]

UPRIGHT, LEVEL = 0.999, 0.05
"""Cosine between the axis of the mount and up from which it counts as upright, and up to which as level."""

LARGEST_DEPARTURE = 0.1
"""Relative departure of the level Earth rate from that of the latitude beyond which gyros are not calibrated."""


def north(args: Namespace) -> Result:
    """Heading of a mount and biases of the gyros, from the means of its dwells.

    With an upright axis the level Earth rate turns in the axes of the unit while biases stay: both components of it,
    and two biases, are estimated. With a level axis one component is told from the biases; the heading and half a turn
    less it then read the same.
    """
    loaded = load(args.recording, ("gyrocompass",), "north")
    scan, lat = loaded.plan, loaded.latitude
    means = dwell_means(loaded.recording, loaded.segmentation)
    if len(means) != len(scan.angles):
        raise RecordingError(f"the plan has {len(scan.angles)} dwells, the recording shows {len(means)}")
    axis = np.eye(3)["xyz".index(scan.axis)]
    C_b_n = attitude(scan.start) @ dcm_from_rotvec(np.array(scan.angles)[:, None] * axis)
    upright = abs(float(axis @ attitude(scan.start)[2]))
    readings, deviation = means[list(GYRO_COLUMNS)].to_numpy(), _deviations(loaded, means)
    level, up = EARTH_RATE * np.cos(lat), EARTH_RATE * np.sin(lat)
    rest = readings - up * C_b_n[:, 2]
    findings: list[Finding] = []
    if upright >= UPRIGHT:
        solution, estimates = _upright(rest, C_b_n, deviation, level)
    elif upright <= LEVEL:
        solution, estimates, other = _level(rest, C_b_n, axis, deviation, level)
        text = f"a scan about a level axis leaves two headings: this one, and {other / DEG % 360:.3f} deg"
        findings.append(Finding(check="ambiguity", severity="doubtful", text=text))
    else:
        raise RecordingError("the axis of the mount must be upright or level")
    findings.append(residual_finding("", solution))
    return loaded.result("north", estimates=estimates, findings=findings, tables={"means": table_of(means)})


def _deviations(loaded, means) -> Array:
    """Standard deviations of the means, shape (dwells, 3): white noise of the samples of each dwell."""
    found = []
    segments = loaded.segmentation.labelled()
    for name, duration in zip(means.index, means["duration"], strict=True):
        s = segments[name]
        values = loaded.recording.table[list(GYRO_COLUMNS)].iloc[s.first : s.last].to_numpy(dtype=float)
        steps = np.diff(values, axis=0)  # free of a slow drift; an edge of motion is a few of many
        scatter = 1.4826 * np.median(np.abs(steps), axis=0) / np.sqrt(2)
        found.append(scatter * np.sqrt(loaded.recording.dt / duration))
    return np.array(found)


def _upright(rest: Array, C_b_n: Array, deviation: Array, level: float) -> tuple[Solution, Estimates]:
    """Heading and three biases with the axis of the mount upright."""
    # the unit stands turned clockwise by the heading: north is, in the axes of the letters, at -heading
    # level rate in the letters' axes: level * (-sin(heading) east + cos(heading) north)
    design = np.concatenate([np.broadcast_to(np.eye(3), C_b_n.shape), C_b_n[:, 1, :, None], -C_b_n[:, 0, :, None]], -1)
    names = ["bias_x", "bias_y", "bias_z", "cosine", "sine"]
    solution = linear(design.reshape(-1, 5), rest.ravel(), standard_deviation=deviation.ravel(), names=names)
    solution.raise_if_unobservable("the dwells of the scan")
    c, s = solution.estimate[3:]
    size = float(np.hypot(c, s))
    if abs(size / level - 1) > LARGEST_DEPARTURE:
        raise RecordingError(
            f"the level rate of the Earth comes out as {size / level:.3g} of what it is: gyros are too noisy or not "
            "calibrated, or the mount turned"
        )
    slopes = np.zeros((4, 5))
    slopes[0, 3:] = np.array([-s, c]) / size**2
    slopes[1:, :3] = np.eye(3)
    covariance = slopes @ solution.covariance @ slopes.T
    values = [np.arctan2(s, c) % (2 * np.pi), *solution.estimate[:3]]
    return solution, Estimates(names=_NAMES, units=_UNITS, values=values, covariance=covariance)


def _level(rest: Array, C_b_n: Array, axis: Array, deviation: Array, level: float) -> tuple[Solution, Estimates, float]:
    """Heading with the axis level: from the rate across the axis; the rate along it cannot be told from a bias."""
    along = C_b_n[0] @ axis  # the axis in the letters' east, north, up
    across = np.array([along[1], -along[0], 0.0])  # level, a right angle clockwise from the axis
    design = np.concatenate([np.broadcast_to(np.eye(3), C_b_n.shape), (across @ C_b_n)[:, :, None]], -1)
    names = ["bias_x", "bias_y", "bias_z", "across"]
    solution = linear(design.reshape(-1, 4), rest.ravel(), standard_deviation=deviation.ravel(), names=names)
    solution.raise_if_unobservable("the dwells of the scan")
    sine = float(solution.estimate[3]) / level
    if abs(sine) > 1:
        raise RecordingError(f"the rate across the axis comes out as {abs(sine):.3g} of the Earth's level rate")
    # north lies clockwise from the axis by an angle whose sine is known; azimuth of the axis is the negative of it
    offset = float(np.arctan2(along[0], along[1]))  # azimuth of the axis by the letters
    azimuth = -float(np.arcsin(sine))
    cosine = float(np.sqrt(max(1 - sine**2, 1e-12)))
    heading, other = (azimuth - offset) % (2 * np.pi), (np.pi - azimuth - offset) % (2 * np.pi)
    # the bias along the axis holds the Earth's rate along it: only those across are biases
    free = [i for i in range(3) if abs(axis[i]) < 0.5]
    slopes = np.zeros((3, 4))
    slopes[0, 3] = -1 / (level * cosine)
    slopes[[1, 2], free] = 1.0
    return (
        solution,
        Estimates(
            names=["heading", *(f"gyro.bias_{'xyz'[i]}" for i in free)],
            units=["rad", "rad/s", "rad/s"],
            values=[heading, *solution.estimate[free]],
            covariance=slopes @ solution.covariance @ slopes.T,
        ),
        other,
    )


_NAMES = ("heading", "gyro.bias_x", "gyro.bias_y", "gyro.bias_z")
_UNITS = ("rad", "rad/s", "rad/s", "rad/s")
