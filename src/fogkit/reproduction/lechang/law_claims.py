"""What the thesis says of its law in words, each as a question that a computation answers.

A function returns whether the statement holds as printed, or a `Proof` where the ledger has a correction of it. Numbers
behind them are in `law_study`, `law_map` and `rates`.
"""

from functools import cache

import numpy as np

from fogkit.claims import Proof
from fogkit.gyrocompass.accuracy import best_harmonic_amplitude, encoder_share, heading_bound, mean_direction
from fogkit.gyrocompass.encoder import Encoder
from fogkit.gyrocompass.frames import pyramid_axes
from fogkit.gyrocompass.gyro_range import check_gyro_range, gyro_peaks
from fogkit.gyrocompass.laws import DwellAndTurn, Fixed, MountLaw, OneWay, QuasiHarmonic
from fogkit.gyrocompass.observability import Observability
from fogkit.reproduction.lechang import law_map, law_study, paper, rates, requirements, simulation
from fogkit.units import ARCMIN, DEG

_ROUNDING = 1e-9


def bound(law: MountLaw, duration: float = paper.EXPERIMENT_TIME, lat: float = paper.ASSUMED_LATITUDE) -> float:
    """Smallest standard deviation of heading, rad, of gyros of the VG951's noise with unknown biases."""
    return heading_bound(law, duration, lat, law_map.random_walk()).std


@cache
def _seen(on: bool, rolling: bool, cube: bool = False) -> Observability:
    return law_study.seen(on, rolling, simulation.CUBE if cube else None)


def _unseen_share(found: Observability, names: tuple[str, ...]) -> np.ndarray:
    """Share, 0 to 1, of each state that lies in directions no better known than by the prior."""
    rows = [found.names.index(name) for name in names]
    return (found.directions[rows, found.rank() :] ** 2).sum(axis=1)


# ---- turning the unit


def turning_keeps_heading() -> bool:
    """Whether a bias, with which a mount at rest knows nothing of heading, costs nothing under whole turns."""
    known = heading_bound(Fixed(), 300.0, paper.ASSUMED_LATITUDE, law_map.random_walk(), bias_std=0.0).std
    turning = bound(OneWay(period=paper.EXPERIMENT_PERIOD))
    return bool(np.isinf(bound(Fixed())) and abs(turning / known - 1) < 1e-6)


def turns_compensate_across_the_axis() -> bool:
    """Whether the level mean of a bias that turns is nothing over whole turns."""
    return abs(mean_direction(OneWay(period=paper.EXPERIMENT_PERIOD))) < _ROUNDING


def heading_is_hidden_at_rest() -> bool:
    """Whether, mount off, at rest, heading with level gyro biases is no better known than at the start."""
    return bool(_unseen_share(_seen(False, False), ("heading",))[0] > 0.9)


def turning_shows_all() -> bool:
    """Whether heading, biases and scale factors are all seen with the mount on, at rest as well as rolling."""
    return all(_seen(True, rolling).rank() == len(simulation.SEEN) for rolling in (False, True))


def all_gyros_are_seen_at_once(cube: bool) -> bool:
    """Whether all biases and scale factors are seen with the mount on and the hull at rest; on a cube, or the pyramid.

    Rolling by five degrees shows what a cube leaves open at rest: the scale factors of its two level gyros.
    """
    return _seen(True, False, cube).rank() == len(simulation.SEEN)


def cube_shows_its_azimuth_gyro_only() -> bool:
    """Whether of gyros on a cube, one along the axis, only the errors of that one are seen."""
    shares = _unseen_share(_seen(True, False, cube=True), ("bias_x", "bias_z"))
    return bool((shares > 0.5).any())  # no: the level gyros' biases are seen, their scale factors are not


def nothing_is_seen_with_the_mount_off(kind: str) -> bool:
    """Whether, mount off and rolling as in the simulation, no "bias" or no "scale_factor" is better known than before.

    A state counts as not seen if more than half of it, in units of the prior, lies in unseen directions.
    """
    names = tuple(f"{kind}_{axis}" for axis in "xyz")
    return bool((_unseen_share(_seen(False, True), names) > 0.5).all())


def heading_is_hidden_when_rolling() -> bool:
    """Whether, mount off and rolling as in the simulation, heading stays hidden."""
    return bool(_unseen_share(_seen(False, True), ("heading",))[0] > 0.9)


# ---- amplitude, period, law


def quasi_harmonic_is_best() -> bool:
    """Whether no law has a smaller bound than the harmonic ones of 90 and 180 degrees."""
    table = law_study.bound_table().heading_arcmin
    own = table[["harmonic, 90 deg", "harmonic, 180 deg"]].max()
    return bool((table >= own * (1 - 1e-6)).all())


def ninety_degrees_is_best() -> bool:
    """Whether an amplitude of 90 degrees, or any in the thesis's range up to a turn, beats those below it for good.

    It does not: the bound at 90 is an ordinary point of a falling curve, the least is at `best_harmonic_amplitude`.
    """
    ninety, best = (bound(QuasiHarmonic(amplitude=a, period=60.0)) for a in (np.pi / 2, best_harmonic_amplitude()))
    return bool(ninety <= best * (1 + 1e-6))


def largest_loss_from(amplitude: float = paper.LEAST_AMPLITUDE) -> float:
    """Largest share by which the bound of a harmonic law of `amplitude`, rad, or more exceeds the best one."""
    from scipy.special import j0

    lost = j0(np.linspace(amplitude, 4 * np.pi, 2000)) ** 2
    return float((1 - lost.max()) ** -0.5 - 1)


def two_positions() -> Proof:
    """Whether ``|sin(beta - K)|`` is largest 90 degrees either side of the heading line, or of the meridian."""
    headings = np.linspace(0, 2 * np.pi, 25)
    printed = np.abs(np.sin(np.array([[-1], [1]]) * np.pi / 2 - headings))
    corrected = np.abs(np.sin(headings + np.array([[-1], [1]]) * np.pi / 2 - headings))
    return Proof(printed=bool((printed > 1 - 1e-12).all()), corrected=bool((corrected > 1 - 1e-12).all()))


def half_turn_changes_the_sign() -> bool:
    """Whether ``exp(i beta)`` changes its sign over half a turn, so that two opposite dwells have no mean direction."""
    angle = np.linspace(0, 2 * np.pi, 37)
    opposite = np.abs(np.exp(1j * (angle + np.pi)) + np.exp(1j * angle)).max()
    left = abs(mean_direction(DwellAndTurn(dwell=30.0, turn_duration=1.0)))
    return bool(opposite < _ROUNDING and left < 1 / 31)  # what is left is of the turns' share of the time


def half_turn_shows_the_bias() -> bool:
    """Whether two opposite dwells give heading beside unknown biases, to a hundredth as well as without any."""
    known = heading_bound(Fixed(), 300.0, paper.ASSUMED_LATITUDE, law_map.random_walk(), bias_std=0.0).std
    return bool(bound(DwellAndTurn(dwell=28.0, turn_duration=2.0)) < 1.01 * known)


def range_limits_the_law() -> bool:
    """Whether 90 degrees in the printed 15 s keep the gyros of the pyramid in range with the hull, and 4 s do not."""
    heading, trim, roll = rates.hull_rates()
    check_gyro_range(QuasiHarmonic(amplitude=np.pi / 2, period=15.3), paper.GYRO_RANGE, (roll, heading, trim))
    fast = gyro_peaks(QuasiHarmonic(amplitude=np.pi / 2, period=4.0), (roll, heading, trim))
    return bool((fast > paper.GYRO_RANGE).all())


def rates_add_as_squares() -> bool:
    """Whether the largest rate of a gyro, the mount at the printed limit, is the root of the sum of squares, 40 deg/s.

    For gyros of the pyramid and for one along the mount's axis.
    """
    heading, trim, roll = rates.hull_rates()
    law = QuasiHarmonic.from_rate(np.pi / 2, rates.budgets()["squares"].mount_rate)
    pyramid = gyro_peaks(law, (roll, heading, trim))[0]
    along = law.max_rate + heading
    return bool(abs(pyramid / paper.RATE_LIMIT - 1) < 0.01 or abs(along / paper.RATE_LIMIT - 1) < 0.01)


def scale_factor_is_met_at_half_range() -> bool:
    """Whether the error that is quoted at half of the range is within the one that is asked for."""
    return paper.SCALE_FACTOR_ERROR[0.5] <= paper.SCALE_FACTOR_LIMIT


def rate_follows_from_the_law() -> bool:
    """Whether (16) is the derivative of (15), by central differences."""
    law = QuasiHarmonic(amplitude=np.pi, period=60.0)
    t, h = np.linspace(0, 60, 101), 1e-3
    slope = (law.angle(t + h) - law.angle(t - h)) / (2 * h)
    return bool(np.abs(slope - law.amplitude * 2 * np.pi / 60 * np.cos(2 * np.pi * t / 60)).max() < 1e-8)


def period_leaves_the_bound() -> bool:
    """Whether with white noise and constant biases the bound is the same for periods of 15 to 300 s."""
    found = [bound(QuasiHarmonic(amplitude=np.pi, period=period)) for period in (15.0, 60.0, 300.0)]
    return bool(max(found) / min(found) < 1 + 1e-6)


def law_is_justified() -> bool:
    """Whether the conclusion holds: harmonic, at least 90 degrees, at least 15 s, for the highest accuracy."""
    return quasi_harmonic_is_best() and ninety_degrees_is_best() and not period_leaves_the_bound()


def latitude_does_not_choose_the_law() -> bool:
    """Whether the bounds of all laws have the same ratios at the equator as at 80 degrees, so that none suits one."""
    turning = {name: law for name, law in law_study.laws().items() if name != "off"}
    equator, north = (np.array([bound(law, lat=lat) for law in turning.values()]) for lat in (0.0, 80 * DEG))
    return bool(np.ptp(north / equator) < _ROUNDING)


# ---- (14) and the case against constant speed


def tilt_enters_by_tan_lat() -> Proof:
    """Whether (14) has all errors of heading; its correction: tilts enter, by ``tan(lat)``."""
    trim_north = requirements.heading_sensitivity(0.0, 0.0, 0.0, paper.ASSUMED_LATITUDE)[3:]
    largest = float(np.abs(trim_north).max())
    return Proof(printed=largest < 1e-6, corrected=abs(largest - np.tan(paper.ASSUMED_LATITUDE)) < 1e-6)


def harmonic_keeps_encoder_errors_out() -> bool:
    """Whether constant speed passes more of a sensor's errors at the reversals into heading than a harmonic law.

    Both pass less than 0.001 arcmin, though the twist of a hard reversal is 60 times that of the harmonic law.
    """
    table = law_study.encoder_table()
    dynamic = table.loc[["reading 10 ms old", "play of 2'", "twist at reversals"]]
    hard, gentle = dynamic["constant speed, 180 deg"].heading, dynamic["harmonic, 180 deg"].heading
    return bool((hard > gentle + 1e-3).any())


def unsteady_speed_speaks_against_constant_speed() -> bool:
    """Whether an unsteady speed leaves more in heading under constant-speed reversal than under a harmonic law.

    Of three gyros neither passes anything; of one alone both pass nothing of a departure that repeats with the angle.
    """
    table = law_study.speed_table()
    return bool((table.loc["constant speed, 180 deg"] > table.loc["harmonic, 180 deg"] + 1e-6).any())


def once_a_turn(law: MountLaw, amplitude: float = ARCMIN) -> float:
    """Largest error of heading, rad, over the phases of a sensor's error of once a turn."""
    encoders = [Encoder(harmonic=amplitude, phase=phase) for phase in (0.0, np.pi / 2)]
    shares = [encoder_share(law, encoder, paper.EXPERIMENT_TIME) for encoder in encoders]
    return float(np.hypot(*shares))


def orientation_of_gyros_leaves_the_bound() -> bool:
    """Whether the level information of a turn of the three gyros is the same for the pyramid as for a cube."""
    level = [axes[[0, 2]] @ axes[[0, 2]].T for axes in (pyramid_axes(), np.eye(3))]
    return bool(np.abs(level[0] - level[1]).max() < _ROUNDING)
