"""What the paper simulates and tests, as far as it says; the rest is named here as assumed."""

import numpy as np

from fogkit.optics import ClosedLoopGyro, Coil, Loop
from fogkit.units import DEG_PER_SECOND_SQUARED, KILOHERTZ, MICROMETRE, MINUTE

ASSUMED_WAVELENGTH = 1.55 * MICROMETRE
"""Wavelength, m: not stated; the usual one for a coil of this length."""

LENGTH = 1000.0
"""Fibre length of the simulated gyro and of both devices, m."""

DIAMETER = 0.1
"""Coil diameter of the simulated gyro, m; assumed for the devices."""

SAMPLING_FREQUENCY = 200 * KILOHERTZ
"""Samples per second of the paper's simulation, Hz; taken as one per half-period of the modulation."""

FEEDBACK_FREQUENCIES = {"device 1": 12.5 * KILOHERTZ, "device 2": 6.25 * KILOHERTZ}
DEPTHS = {"device 1": 3 * np.pi / 4, "device 2": 7 * np.pi / 8}

OSCILLATION_FREQUENCY = 60.0
"""Frequency of the angular oscillation in simulation and experiment, Hz."""

SIMULATED_ACCELERATIONS = np.array([100, 1000, 5000, 10000, 20000, 30000, 40000, 50000]) * DEG_PER_SECOND_SQUARED
"""Amplitudes over the range that the paper simulates, rad/s^2; it states the two ends."""

FIGURE_1_ACCELERATION = 5000 * DEG_PER_SECOND_SQUARED
"""Amplitude of the angular acceleration in Fig. 1, rad/s^2."""

MEASURED_ACCELERATIONS = np.array([1, 2, 5, 10, 20, 30, 40, 50, 60, 70, 80, 90, 100]) * 1000 * DEG_PER_SECOND_SQUARED
"""Amplitudes up to the largest of the test rig, rad/s^2; the paper states that end."""

RUN_DURATION = (3 * MINUTE, 5 * MINUTE)
"""Shortest and longest duration of a run on the rig, s."""


def make_gyro(device: str = "device 1", *, wavelength: float = ASSUMED_WAVELENGTH, **loop) -> ClosedLoopGyro:
    """One of the paper's gyros.

    Parameters
    ----------
    device : {"device 1", "device 2"}, optional
        Device 1 has the parameters of the simulated gyro.
    wavelength : float, optional
        Wavelength, m.
    **loop
        Parameters of `fogkit.optics.Loop` that replace the paper's.
    """
    half_period = 1 / SAMPLING_FREQUENCY
    paper = {
        "depth": DEPTHS[device],
        "half_period": half_period,
        "half_periods": round(1 / FEEDBACK_FREQUENCIES[device] / half_period),
    }
    return ClosedLoopGyro(
        coil=Coil(length=LENGTH, diameter=DIAMETER, wavelength=wavelength), loop=Loop(**(paper | loop))
    )


SIMULATED = make_gyro()
"""The gyro of the paper's simulation, unit gain."""

DEVICES = {device: make_gyro(device) for device in DEPTHS}
"""The two devices of the experiment, as far as they are described, unit gain."""
