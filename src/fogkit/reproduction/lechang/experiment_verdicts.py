"""What becomes of the statements of chapter 4: one function for each, for the ledger."""

import numpy as np

from fogkit.gyrocompass.accuracy import accelerometer_share, heading_bound
from fogkit.gyrocompass.covariance import run_covariance
from fogkit.gyrocompass.gyro_range import gyro_peaks
from fogkit.gyrocompass.scan import scan_readings
from fogkit.noise import RandomErrors
from fogkit.reproduction.lechang import experiments, paper, scanning
from fogkit.units import ARCMIN, ARCSEC, DEG, DEG_PER_HOUR

LEVEL = 30 * ARCSEC
"""To which the plate was levelled, and out of square of the stand's axes in table 5."""


def scan_of_table_6() -> dict[str, float]:
    """What `fogkit.gyrocompass.scan.fit_scan` returns for readings made of table 6, in the units of the table."""
    fit = scanning.other_heading()
    right = int(np.argmin(np.abs(fit.headings - paper.STAND_HEADING)))
    values = {"heading": fit.headings[right] / DEG}
    values |= {f"scale-{g}": fit.scales[k] * DEG / 1e-3 for k, g in enumerate("xyz")}
    values |= {f"bias-{g}": fit.biases[right, k] / DEG for k, g in enumerate("xyz")}
    return {name: float(value) for name, value in values.items()}


def scan_tells_heading() -> bool:
    """Whether the readings of the scan leave one heading only: not if another explains them to 1e-9 of their swing."""
    fit = scanning.other_heading()
    made = [
        scan_readings(scanning.angles(), heading, paper.ASSUMED_LATITUDE, fit.scales, biases)
        for heading, biases in zip(fit.headings, fit.biases, strict=True)
    ]
    apart = np.abs(np.exp(1j * fit.headings[0]) - np.exp(1j * fit.headings[1]))
    return bool(apart < 1e-3 or np.abs(made[0] - made[1]).max() > 1e-9 * scanning.amplitudes().min())


def dwell_for(heading_std: float = paper.HEADING_ACCURACY, sides: int = 2) -> float:
    """Time in each of 12 positions, s, after which white noise alone leaves a standard deviation of heading, rad."""
    walk = RandomErrors(angle_random_walk=paper.random_walk_of_the_data_sheet(sides))
    one = scanning.scatter(walk, 60.0)["heading"]  # falls with the square root of time
    return float(60.0 * (one / heading_std) ** 2)


def readings_are_harmonic(gyro: int) -> bool:
    """Whether the reading of a gyro by table 6 is a sine of the angle plus a mean, in thousandths of a volt."""
    at = scanning.angles(360)
    reading = scanning.figure_readings(at)[:, gyro]
    waves = np.abs(np.fft.rfft(reading)) / len(at)
    harmonic = waves[2:].max() < 1e-6 * waves[1]
    return bool(harmonic and 0.1e-3 < np.abs(reading).max() < 10e-3)


def level_share() -> float:
    """Error of heading from 30 arcsec of tilt, arcmin."""
    return accelerometer_share(paper.ASSUMED_LATITUDE, LEVEL) / ARCMIN


def peak_rate() -> float:
    """Largest rate that a gyro sees in the experiment, over the range of the VG951."""
    return float(gyro_peaks(experiments.LAWS["harmonic 180"]).max() / paper.GYRO_RANGE)


def accuracy(known: str = "scan", velocity_std: float = 0.001, sides: int = 2) -> float:
    """Standard deviation of heading after the five minutes, arcmin, by the covariance."""
    return experiments.predicted_std("harmonic 180", sides, velocity_std, known) / ARCMIN


def time_for_accuracy(sides: int = 2, law: str = "harmonic 180") -> float:
    """Time, s, after which the bound of heading is 30 arcmin, the stand known not to turn."""
    from scipy.optimize import brentq

    walk, lat = paper.random_walk_of_the_data_sheet(sides), paper.ASSUMED_LATITUDE

    def over(periods: float) -> float:
        bound = heading_bound(experiments.LAWS[law], periods * paper.EXPERIMENT_PERIOD, lat, walk)
        return bound.std - paper.EXPERIMENT_ACCURACY

    return float(brentq(over, 1.0, 20.0, xtol=1e-4)) * paper.EXPERIMENT_PERIOD


def chance_within_a_degree(std: float, of_experiment_1: float = 0.0) -> float:
    """Chance that both headings differ by less than a degree, given their standard deviations, rad."""
    from scipy.special import erf

    return float(erf(1 * DEG / np.hypot(std, of_experiment_1) / np.sqrt(2)))


def agreement_shows_accuracy() -> bool:
    """Whether "less than 1 deg" tells 30 arcmin from 60: not if the latter makes it at least half as likely."""
    right, poor = (chance_within_a_degree(k * paper.EXPERIMENT_ACCURACY) for k in (1, 2))
    return poor < 0.5 * right


def accuracy_follows_noise() -> bool:
    """Whether half the angle random walk gives half the standard deviation."""
    law, lat = experiments.LAWS["harmonic 180"], paper.ASSUMED_LATITUDE
    walk = paper.random_walk_of_the_data_sheet(2)
    stds = [heading_bound(law, paper.EXPERIMENT_TIME, lat, k * walk).std for k in (1.0, 0.5)]
    return bool(np.isclose(stds[1] / stds[0], 0.5))


def bias_stds(known: str = "data sheet", velocity_std: float = 0.001) -> np.ndarray:
    """Standard deviations of the bias after the experiment, along the mount's axes forward, up, starboard, rad/s."""
    motion, noise = experiments.motion("harmonic 180"), experiments.noise(2)
    run = run_covariance(motion, noise, experiments.aid(velocity_std), experiments.prior(known))
    return np.sqrt(np.diag(motion.axes @ run.covariance[9:12, 9:12] @ motion.axes.T))


def biases_confirmed() -> bool:
    """Whether experiment 2 can check the biases of experiment 1: all three to the 3.6 deg/h of table 6's last digit.

    It cannot: the bias along the axis of the mount looks like a turning stand, and the aid does not say that it rests.
    """
    return bool(bias_stds().max() < 3.6 * DEG_PER_HOUR)


def scale_of_y_would_show() -> bool:
    """Whether experiment 2 shows a gyro y of 34 mV/(deg/s) taken for one of 18.3: by far more than its deviation."""
    wrong = abs(paper.DATA_SHEET_SCALE / abs(paper.STAND_SCALES[1]) - 1)
    return bool(wrong > 10 * experiments.known_scale_std()[1])


def drift_of_y() -> float:
    """Drift of once per scan that would make gyro y's 18.3 of 34 mV/(deg/s), deg/h: `scanning.drift_of_scale`."""
    return scanning.drift_of_scale(1) / DEG_PER_HOUR
