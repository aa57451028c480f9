"""Gyros that several optics tests share."""

import numpy as np
import pytest

from fogkit.optics import ClosedLoopGyro, Coil, Loop


@pytest.fixture
def make_gyro():
    """Gyro of the paper's simulation, with loop parameters and noise as asked for."""

    def make(detector_noise=0.0, shot_noise=0.0, intensity_noise=0.0, **loop):
        parameters = {"depth": 3 * np.pi / 4, "half_period": 5e-6, "half_periods": 16} | loop
        return ClosedLoopGyro(
            coil=Coil(length=1000, diameter=0.1),
            loop=Loop(**parameters),
            detector_noise=detector_noise,
            shot_noise=shot_noise,
            intensity_noise=intensity_noise,
        )

    return make
