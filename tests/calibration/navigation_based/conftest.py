"""One rough table, one unit, one set of recordings for all tests of the method."""

from types import SimpleNamespace

import numpy as np
import pytest

from fogkit.calibration.navigation_based import Compensation
from fogkit.imu.triads import LinearTriad
from fogkit.imu.unit import MeasurementUnit, Sensors
from fogkit.stand.rough_table import RoughTable
from fogkit.stand.turn_recordings import record
from fogkit.stand.turn_tests import nine_tests
from fogkit.units import DEG

LATITUDE = 53.9 * DEG


def raw_unit(rng, matrix=1e-3, bias=1e-2, gyro_bias=0.0):
    """Unit with full matrices: 1e-3 is 1000 ppm and 200 arcsec."""

    def triad(size):
        return LinearTriad(matrix=np.eye(3) + matrix * rng.normal(size=(3, 3)), bias=size * rng.normal(size=3))

    return MeasurementUnit(gyros=Sensors(triad=triad(gyro_bias)), accelerometers=Sensors(triad=triad(bias)))


def true_starts(motions, truth):
    """Attitudes at the start, of the axes that the paper's zeros define: those of the calibration."""
    C_b_gauge = truth.gauged().accelerometer_matrix @ np.linalg.inv(truth.accelerometer_matrix)
    return np.stack([motion.C_b_n(np.zeros(1))[0] for motion in motions]) @ C_b_gauge.T


@pytest.fixture(scope="session")
def case():
    """Noise-free recordings of the nine tests on a typical rough table, 100 Hz, dwells of 5 s, turns of 12 s."""
    rng = np.random.default_rng(11)
    plan = nine_tests(dwell=5.0, turn_duration=12.0)
    unit = raw_unit(rng)
    motions = RoughTable.typical(LATITUDE).motions(plan, rng)
    truth = Compensation.from_unit(unit)
    recordings = record(unit, motions, 100.0)
    return SimpleNamespace(
        plan=plan,
        unit=unit,
        truth=truth,
        motions=motions,
        recordings=recordings,
        starts=true_starts(motions, truth),
        latitude=LATITUDE,
    )
