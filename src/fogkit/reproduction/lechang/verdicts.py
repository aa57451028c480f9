"""The thesis's claims in words on compasses, frames and equations: each function says whether one holds as made.

What "seen" and "kept" mean in numbers is stated with each. Claims on the law, the requirements, the simulation and the
experiments are judged in modules of their own.
"""

from functools import cache
from itertools import permutations, product

import numpy as np
from scipy.spatial.transform import Rotation

from fogkit.claims import Proof
from fogkit.constants import EARTH_RATE
from fogkit.gyrocompass import scan
from fogkit.gyrocompass.accuracy import heading_bound, mean_direction
from fogkit.gyrocompass.covariance import Aid, Noise, run_covariance
from fogkit.gyrocompass.frames import TO_PACKAGE, hull_attitude, mount_attitude, package_attitude, pyramid_axes
from fogkit.gyrocompass.laws import ConstantSpeedReversal, Fixed, OneWay, QuasiHarmonic
from fogkit.gyrocompass.mechanisation import CompassState, Reading, geographic_rate, gyro_rates, state_rate
from fogkit.reproduction.lechang import derivation, paper, requirements, simulation, turns
from fogkit.rotation import dcm_from_heading_pitch_roll
from fogkit.units import DEG, MINUTE

LATITUDES = (0.0, 45 * DEG, paper.ASSUMED_LATITUDE, 80 * DEG)
"""Where claims without a latitude are tried, rad."""

SEEN = 0.01
"""Share of its prior to which almost perfect gyros and aid must bring an error in 400 s for it to be called seen."""


# ---- compasses, introduction and chapter 1


def turning_replaces_better_gyros() -> bool:
    """Whether a VG951 on a rocked mount bounds heading better than gyros of table 3 that stand, in five minutes."""
    rocked = QuasiHarmonic(amplitude=paper.EXPERIMENT_AMPLITUDE, period=paper.EXPERIMENT_PERIOD)
    cheap, good = paper.random_walk_of_the_data_sheet(2), paper.REQUIRED_RANDOM_WALK
    time = paper.EXPERIMENT_TIME
    return all(
        heading_bound(rocked, time, lat, cheap, bias_std=paper.DATA_SHEET_BIAS).std
        < heading_bound(Fixed(), time, lat, good, bias_std=paper.REQUIRED_BIAS).std
        for lat in LATITUDES
    )


def pendulum_seeks_the_meridian() -> bool:
    """Whether the weight under a level gyro turns its axis towards the meridian, from the east and from the west.

    The Earth turns for a minute under a free axis, one end of which then stands above or below the horizon. The torque
    of a weight hung across the axis, ``-n x (-up)`` of the direction ``n`` across it, is where the axis precesses to.
    """
    north, up, east = np.eye(3)
    for lat in (0.0, 45 * DEG, paper.ASSUMED_LATITUDE, -45 * DEG):
        earth = EARTH_RATE * np.array([np.cos(lat), np.sin(lat), 0.0])
        for start, sign in ((east, 1), (-east, -1)):
            axis = Rotation.from_rotvec(-earth * MINUTE).apply(start)
            across = up - (axis @ up) * axis
            if not (sign * (axis @ up) > 0 and np.cross(across, up) @ north > 0):
                return False
    return True


def level_gyro_reads_eq01() -> bool:
    """Whether (1) is the Earth's rate on a level axis, by the attitude of a hull whose bow is that axis."""
    azimuth = np.linspace(-3, 3, 25)
    return all(
        np.allclose(
            scan.level_reading(azimuth, lat, offset=3.0, scale=2.0),
            3.0 + 2.0 * hull_attitude(azimuth, 0.0, 0.0)[:, :, 0] @ geographic_rate(lat, np.zeros(3)),
            rtol=0,
            atol=1e-15,
        )
        for lat in LATITUDES
    )


def eq02_inverts_eq01() -> bool:
    """Whether (2) gives back azimuths east of the meridian, and for those west of it their mirror image."""
    lat = paper.ASSUMED_LATITUDE
    azimuth = np.linspace(0.1, 3.0, 20)
    found = [scan.azimuths(float(scan.level_reading(a, lat)), lat)[0] for a in (*azimuth, *-azimuth)]
    return bool(np.allclose(found, [*azimuth, *azimuth], atol=1e-12))


def at_rest_nothing_changes() -> bool:
    """Whether the mechanisation fed with true readings of a vessel at rest keeps angles, velocity and position."""
    motion = simulation.vessel(rolling=False).motion(100.0, 0.1, simulation.mount())
    heading, trim, roll, *velocity, lat, lon, alt = motion.states[0]
    state = CompassState(heading=heading, trim=trim, roll=roll, velocity=velocity, lat=lat, lon=lon, alt=alt)
    rates = [
        state_rate(state, Reading(rates=w, specific_force=f, mount_angle=b, mount_rate=r), gravity=motion.gravity)
        for w, f, b, r in zip(
            motion.rates[::100],
            motion.specific_force[::100],
            motion.mount_angle[::100],
            motion.mount_rate[::100],
            strict=True,
        )
    ]
    return bool(np.abs(rates).max() < 1e-12)


@cache
def left_of(mount: bool, rolling: bool, cube: bool = False) -> dict[str, float]:
    """What is left of heading, biases and scale factors, as shares of the prior: `simulation.unseen` by name."""
    axes = simulation.CUBE if cube else None
    fractions, directions = simulation.unseen(simulation.mount() if mount else None, rolling, axes)
    covariance = directions @ np.diag(fractions**2) @ directions.T
    return dict(zip(simulation.SEEN, np.sqrt(np.diag(covariance)).tolist(), strict=True))


def fixed_unit_hides_heading() -> bool:
    """Whether with the mount off, at rest, heading keeps 95 % of its prior, together with a level bias."""
    fractions, directions = simulation.unseen(None, rolling=False)
    hidden = directions[:, fractions > 0.95]
    at_all = np.linalg.norm(hidden[1:4])  # of the biases in what is hidden, in units of the prior
    return bool(left_of(mount=False, rolling=False)["heading"] > 0.95 and at_all > 0.05)


def fixed_unit_shows_all() -> bool:
    """Whether with the mount off, at rest, every one of them is seen."""
    return max(left_of(mount=False, rolling=False).values()) < SEEN


def turning_shows_all() -> bool:
    """Whether with the mount on, at rest and rolling, every one of heading, biases and scale factors is seen."""
    return all(max(left_of(mount=True, rolling=rolling).values()) < SEEN for rolling in (False, True))


def cube_shows_azimuth_gyro_only() -> bool:
    """Whether on a cube, at rest, each error of a level gyro stays larger than that of its kind of the azimuth gyro."""
    left = left_of(mount=True, rolling=False, cube=True)
    return all(left[f"{kind}_{gyro}"] > left[f"{kind}_y"] for kind in ("bias", "scale_factor") for gyro in "xz")


def cube_hides_an_error() -> bool:
    """Whether on a cube, at rest, an error of some gyro is not seen: Table 1 denies that all are, all at once."""
    return max(left_of(mount=True, rolling=False, cube=True).values()) > 0.1


def each_gyro_is_turned() -> bool:
    """Whether every gyro of the pyramid has the same part of the mount's rate, and not none."""
    still, turned = gyro_rates(np.zeros((2, 3)), 0.3, np.array([0.0, 1.0]))
    return bool(np.allclose(turned - still, 3**-0.5, atol=1e-12))


def turning_compensates_across_the_axis() -> bool:
    """Whether whole turns leave nothing of biases across the axis in hull axes, and all of those along it."""
    laws = (OneWay(period=60.0), ConstantSpeedReversal(amplitude=np.pi, period=60.0))
    angles = np.linspace(0, 2 * np.pi, 360, endpoint=False)
    kept = mount_attitude(angles).mean(axis=0)
    across = all(abs(mean_direction(law)) < 1e-3 for law in laws)
    return bool(across and np.allclose(kept, np.diag([0.0, 1.0, 0.0]), atol=1e-12))


@cache
def aiding_bounds_errors(duration: float = 3600.0) -> bool:
    """Whether in an hour errors of velocity, trim, roll and height stop growing with an aid, and grow on without.

    "Without" is an aid of the same kind with errors a million times as large. Heading is not among them: an aid
    does not bound it with the mount off (`fixed_unit_hides_heading`).
    """
    motion = simulation.vessel().motion(duration, 0.05)
    noise, prior = Noise(angle_random_walk=paper.SIMULATED_RANDOM_WALK), simulation.ASSUMED_PRIOR
    poor = Aid.satellite(paper.ASSUMED_LATITUDE, velocity=1e5, position=3e6)
    kept = [1, 2, 3, 4, 5, 8]
    aided, unaided = (
        run_covariance(motion, noise, aid, prior, output_interval=60.0).std[:, kept]
        for aid in (Aid.satellite(paper.ASSUMED_LATITUDE), poor)
    )
    third = len(aided) // 3
    bounded = (aided[2 * third :].max(axis=0) <= 1.1 * aided[third : 2 * third].max(axis=0)).all()
    return bool(bounded and (unaided[-third:].max(axis=0) > 10 * aided[-third:].max(axis=0)).all())


# ---- frames, chapter 2


def euler_angles() -> tuple[float, float, float]:
    """Turns about y, z, y, deg, of gyros that are inclined alike, thirds of a turn apart, gyro y as (13) has it."""
    y = np.array([np.sqrt(2 / 3), 3**-0.5, 0.0])
    third = Rotation.from_rotvec([0.0, 2 * np.pi / 3, 0.0])
    for x, z in permutations((third.apply(y), third.inv().apply(y))):
        axes = np.column_stack([x, y, z])
        if np.linalg.det(axes) > 0:
            angles = Rotation.from_matrix(axes).as_euler("YZY", degrees=True)
    return float(abs(angles[0])), float(angles[1]), float(angles[2])


def sign_of_eq13(first: float) -> float:
    """Sign of the first term of (13) when the first Euler angle, deg, is another and the two others are as printed."""
    angles = np.array([first, *paper.PYRAMID_ANGLES_DEG[1:]]) * DEG
    return float(np.sign(pyramid_axes(angles)[0, 1]))


def inclination_that_is_orthogonal() -> float:
    """Inclination, deg, to the axis at which three directions a third of a turn apart are orthogonal, by bisection."""

    def cosine(angle: float) -> float:
        azimuth = 2 * np.pi / 3
        first = np.array([np.sin(angle), 0.0, np.cos(angle)])
        second = np.array([np.sin(angle) * np.cos(azimuth), np.sin(angle) * np.sin(azimuth), np.cos(angle)])
        return float(first @ second)

    low, high = 0.0, np.pi / 2
    while high - low > 1e-9:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if cosine(middle) > 0 else (low, middle)
    return float(np.rad2deg(low))


def frames_are_as_stated() -> bool:
    """Whether both frames are right-handed and heading, trim, roll are those of the package, at random angles."""
    angles = np.random.default_rng(26).uniform(-1.2, 1.2, (20, 3))
    converted = package_attitude(hull_attitude(*angles.T))
    north, up, east = TO_PACKAGE.T  # in east-north-up
    handed = np.allclose(np.cross(north, up), east) and np.allclose([north, up, east], np.eye(3)[[1, 2, 0]])
    return bool(handed and np.allclose(converted, dcm_from_heading_pitch_roll(*angles.T), atol=1e-12))


def sense_of_the_mount() -> bool:
    """Whether (13) holds if the hull is turned from the mount by ``beta`` clockwise, as heading, and not otherwise."""
    level = geographic_rate(paper.ASSUMED_LATITUDE, np.zeros(3))
    k_1 = np.sqrt(2 / 3) * level[0]

    def holds(sense: int) -> bool:
        return all(
            np.isclose(
                gyro_rates(hull_attitude(K, 0.0, 0.0).T @ level, sense * beta, 0.0)[1],
                k_1 * np.cos(beta - K) + level[1] / np.sqrt(3),
                rtol=0,
                atol=1e-15,
            )
            for K, beta in product((0.3, 1.1, 2.5), (0.4, -1.3))
        )

    return holds(1) and not holds(-1)


def mount_stands_on_the_normal() -> Proof:
    """Whether gyro y has ``1/sqrt(3)`` of the mount's rate, as in (13), with a mount about forward, and about up."""
    forward, up, _ = pyramid_axes()[:, 1]
    return Proof(printed=bool(np.isclose(forward, 3**-0.5)), corrected=bool(np.isclose(up, 3**-0.5)))


def accelerometers_do_not_turn() -> bool:
    """Whether the mount changes nothing of what the accelerometers read."""
    vessel = simulation.vessel()
    on, off = (vessel.motion(60.0, 0.1, law).specific_force for law in (simulation.mount(), None))
    return bool(np.array_equal(on, off))


# ---- equations, chapter 2


def restored(name: str) -> bool:
    """Whether a restored coefficient of (8) follows by symbols, and the error model agrees with differences."""
    return derivation.holds(name) and turns.error_model_departure() < turns.TOLERANCE


def restored_17(name: str) -> bool:
    """Whether a restored coefficient of (17) follows by symbols and by differences of the arc tangent."""
    heading, trim, roll, lat = 0.7, 0.15, -0.1, paper.ASSUMED_LATITUDE
    order = ("gyro-x", "gyro-y", "gyro-z", "trim", "roll")
    number = requirements.heading_sensitivity(heading, trim, roll, lat)[order.index(name)]
    level = EARTH_RATE * np.cos(lat)
    gyros = gyro_rates(hull_attitude(heading, trim, roll).T @ geographic_rate(lat, np.zeros(3)), 0.0, 0.0)
    values = {"theta": trim, "gamma": roll, "omega_NK": level * np.cos(heading), "omega_EK": -level * np.sin(heading)}
    values |= dict(zip(("w_xb", "w_yb", "w_zb"), gyros, strict=True))
    printed = derivation.equations()[f"eq17-{name}"].printed
    value = float(printed.subs({symbol: values[str(symbol)] for symbol in printed.free_symbols}))
    return derivation.holds(f"eq17-{name}") and bool(np.isclose(number, np.cos(heading) ** 2 * value, rtol=1e-6))


def half_turn_changes_the_sign() -> bool:
    """Whether heading by (14) takes a bias of gyro y with the other sign after half a turn of the mount."""
    import sympy

    slope = derivation.equations()["eq14-heading"].derived  # change of the reading with heading
    beta = next(symbol for symbol in slope.free_symbols if str(symbol) == "beta")
    return derivation.Equation(slope.subs(beta, beta + sympy.pi), -slope).holds


def middle_class_of_gyros() -> float:
    """Bias of the VG951, of the middle class by chapter 4, over that of table 3, of the middle class by chapter 3."""
    return float(paper.DATA_SHEET_BIAS / paper.REQUIRED_BIAS)
