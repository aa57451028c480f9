"""Are these the recordings that the plan speaks of? Units, faces, turns, rest, saturation: each said in words."""

import warnings
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fogkit.calibration.navigation_based.compensation import Compensation
from fogkit.calibration.navigation_based.recordings import MOVING, Recording, find_dwells, motion_in
from fogkit.constants import EARTH_RATE
from fogkit.estimation import Solution
from fogkit.stand.turn_tests import AXES, TurnTest
from fogkit.units import DEG, PPM

Array = NDArray[np.float64]

GRAVITY_TOLERANCE = 0.05
"""Largest relative departure of the specific force at rest from gravity: a unit straight from the factory has 1 %."""

LARGEST_TILT_OF_START = 20 * DEG
"""Angle between what the accelerometers and what the plan call up that is a wrong test and not a rough table."""

TURN_TOLERANCE = 0.05
"""Relative difference of turned and planned angle that is another turn; a quarter turn besides is one in any case, and
the axis may be off by `LARGEST_TILT_OF_START`."""

RINGING = 0.05 * DEG
"""Angle turned within a dwell in `recordings.WINDOW` that is worth a warning."""

SATURATED_RUN = 20
"""Equal readings in a row, at the largest of a recording, that no noise lets happen."""

STEADY = 1e-6
"""Difference of the mean rates in two halves of a rest, rad/s, beyond six deviations that is worth a warning: 0.2
deg/h, far more than the biases of calibrated gyros move in minutes."""

BLOCK = 1.0
"""Duration, s, of the blocks whose scatter says what noise makes of a mean rate."""

SHORTFALL = 0.005
"""Part of the planned angle that is missing where gyros are saturated; rough tables are exact to a tenth of it."""


def check(recordings: Sequence[Recording], start: Compensation, gravity: float) -> None:
    """Raise what is wrong with recordings, the plainest first.

    Parameters
    ----------
    recordings : sequence of Recording
        The tests.
    start : Compensation
        What is known of the unit.
    gravity : float
        Magnitude, m/s^2.

    Raises
    ------
    ValueError
        For wrong units (1 g check, angle of the turn), a dwell in motion, a start or an end on another face than
        planned (with the test that would fit), another turn, saturation, or a channel that hangs. The message names
        test and dwell.

    Warns
    -----
    UserWarning
        If a dwell moves a little, as on ringing shock absorbers.
    """
    plan = [recording.test for recording in recordings]
    for recording in recordings:
        name = f"recordings[{plan.index(recording.test)}] (test {recording.test.label})"
        _units(recording, start, gravity, name)
        _gyro_units(recording, start, name)
        _rest(recording, name)
        _saturation(recording, name)
        _faces(recording, start, plan, name)
        _turn(recording, start, plan, name)


def warn_of_few_turns(plan: Sequence[TurnTest], solution: Solution) -> None:
    """Warn if no test makes a whole turn about an axis: the scale factor of its gyro is then known no better."""
    for i, axis in enumerate(AXES):
        angle = max(abs(test.angle * test.axis[i]) for test in plan)
        deviation = solution.standard_deviation[solution.index(f"m_g_{i + 1}{i + 1}")]
        if angle < 2 * np.pi:
            warnings.warn(
                f"no test turns by more than {angle / DEG:.0f} deg about {axis}: the scale factor of that gyro is "
                f"known to {deviation / PPM:.2g} ppm at best. `turns_needed` says how many whole turns it takes.",
                UserWarning,
                stacklevel=4,
            )


def warn_of_drift(rates: Array, dt: float, name: str) -> None:
    """Warn if the mean rates in the two halves of a rest differ by more than noise: the unit moves, or biases drift.

    Parameters
    ----------
    rates : ndarray, shape (n, 3)
        Rates at rest, rad/s.
    dt : float
        Step, s.
    name : str
        What rests, for the message.
    """
    steps = min(max(1, round(BLOCK / dt)), len(rates) // 4)
    blocks = rates[: len(rates) // steps * steps].reshape(-1, steps, 3).mean(axis=1)
    half = len(blocks) // 2
    apart = np.abs(blocks[:half].mean(axis=0) - blocks[half:].mean(axis=0))
    # successive differences do not see a motion of a few blocks; their median is 0.954 deviations of white noise
    deviation = np.median(np.abs(np.diff(blocks, axis=0)), axis=0) / 0.954
    beyond = apart - (STEADY + 6 * deviation * 2 / np.sqrt(len(blocks)))
    worst = int(np.argmax(beyond))
    if beyond[worst] > 0:
        warnings.warn(
            f"the mean rates about {AXES[worst]} in the halves of {name} differ by {apart[worst]:.2g} rad/s: the unit "
            "moves, or a bias drifts. No bias is known better than that",
            UserWarning,
            stacklevel=3,
        )


def _units(recording: Recording, start: Compensation, gravity: float, name: str) -> None:
    """1 g check."""
    forces = recording.forces @ start.accelerometer_matrix.T + start.accelerometer_bias
    for dwell, felt in enumerate(np.linalg.norm(forces, axis=1), start=1):
        if abs(felt / gravity - 1) <= GRAVITY_TOLERANCE:
            continue
        hints = {
            "These look like specific forces in place of increments: multiply by the step.": felt * recording.dt,
            "These look like increments in units of g s: multiply by 9.80665.": felt * gravity,
            "These look like specific forces in units of g.": felt * recording.dt * gravity,
        }
        hint = next((h for h, value in hints.items() if abs(value / gravity - 1) <= GRAVITY_TOLERANCE), "")
        hint = hint or "Is the step of the index that of the increments? A recording is thinned out by sums."
        raise ValueError(
            f"`{name}` must feel gravity, {gravity:.4g} m/s^2, in dwell {dwell}, got {felt:.4g} m/s^2. {hint}".rstrip()
        )


def _gyro_units(recording: Recording, start: Compensation, name: str) -> None:
    """Whether the turn is that of the plan in other units; seen before the dwells, which then seem to move."""
    test, turned = recording.test, start.gyro_matrix @ recording.turned
    ratio = float(turned @ test.axis) / test.angle
    for factor, words in (
        (1 / DEG, "in deg in place of rad"),
        (1 / recording.dt, "rates in place of increments"),
        (1 / (DEG * recording.dt), "rates in deg/s"),
    ):
        other = abs(factor - 1) > 2 * TURN_TOLERANCE  # with steps of 1 s rates and increments are the same
        if other and abs(ratio / factor - 1) < TURN_TOLERANCE:
            raise ValueError(_another_turn(recording, turned, name, f" These look like {words}."))


def _rest(recording: Recording, name: str) -> None:
    for number, dwell in enumerate(recording.dwells, start=1):
        angle, when = motion_in(recording.gyro, recording.dt, dwell)
        drift = np.linalg.norm(recording.gyro[slice(*dwell)].sum(axis=0))
        allowed = MOVING + 2 * EARTH_RATE * (dwell[1] - dwell[0]) * recording.dt
        if angle > MOVING or drift > allowed:
            found = find_dwells(recording.gyro, recording.dt)
            seen = ""
            if found is not None:
                (a, b), (c, d) = (np.array(rest) * recording.dt for rest in found)
                seen = f" The gyros rest from {a:.4g} to {b:.4g} s and from {c:.4g} to {d:.4g} s."
            raise ValueError(
                f"`{name}` must be at rest in dwell {number}, {dwell[0] * recording.dt:.4g} to "
                f"{dwell[1] * recording.dt:.4g} s, got a motion of {max(angle, drift) / DEG:.3g} deg, "
                f"largest at {when:.4g} s.{seen} `dwells='detected'` takes those."
            )
        if angle > RINGING:
            warnings.warn(
                f"`{name}` moves by {angle / DEG:.2g} deg in dwell {number}, at {when:.4g} s: `settle` leaves out what "
                "rings after the turn",
                UserWarning,
                stacklevel=5,
            )


def _saturation(recording: Recording, name: str) -> None:
    from fogkit.imu.tables import IMU_COLUMNS

    for i, column in enumerate(IMU_COLUMNS):
        values = (recording.gyro if i < 3 else recording.accel)[:, i % 3]
        rest = np.concatenate([np.diff(values[slice(*dwell)]) for dwell in recording.dwells])
        noisy = np.mean(rest == 0) < 0.1 and np.abs(rest).max() > 1e-9 * np.abs(values).max()
        run, begin, extreme = _longest_run_at_extreme(values)
        if run < SATURATED_RUN:
            if noisy:
                _require_change(values, recording.dt, column, name)
            continue
        planned = recording.test.angle * recording.test.axis[i % 3]
        short = i < 3 and abs(recording.turned[i]) < (1 - SHORTFALL) * abs(planned)
        if noisy or short:
            raise ValueError(
                f"`{name}` must not be saturated, got {run} equal readings of {extreme:.6g} in a row in {column!r} "
                f"from {begin * recording.dt:.6g} s, its largest. Turn more slowly."
            )


def _require_change(values: Array, dt: float, column: str, name: str) -> None:
    """``ValueError`` if a channel with noise repeats a reading for long."""
    ends = np.flatnonzero(np.append(np.diff(values) != 0, True))
    lengths = np.diff(ends, prepend=-1)
    longest = int(np.argmax(lengths))
    if lengths[longest] >= SATURATED_RUN:
        begin = ends[longest] - lengths[longest] + 1
        raise ValueError(
            f"`{name}` must not hang, got {lengths[longest]} equal readings of {values[begin]:.6g} in a row in "
            f"{column!r} from {begin * dt:.6g} s, though the channel is noisy. Was something lost and filled?"
        )


def _longest_run_at_extreme(values: Array) -> tuple[int, int, float]:
    """Longest run of equal readings that are the largest or the smallest of all; its length, beginning and value."""
    best = (0, 0, 0.0)
    for extreme in (values.max(), values.min()):
        if np.count_nonzero(values == extreme) < SATURATED_RUN:
            continue
        at = np.flatnonzero(np.diff(np.concatenate([[False], values == extreme, [False]]).astype(np.int8)))
        lengths = at[1::2] - at[::2]
        longest = int(np.argmax(lengths))
        if lengths[longest] > best[0] and abs(extreme) == np.abs(values).max():
            best = int(lengths[longest]), int(at[2 * longest]), float(extreme)
    return best


def _faces(recording: Recording, start: Compensation, plan: Sequence[TurnTest], name: str) -> None:
    """Whether the accelerometers say up where the plan does, at the start and at the end."""
    forces = recording.forces @ start.accelerometer_matrix.T + start.accelerometer_bias
    up = forces / np.linalg.norm(forces, axis=1, keepdims=True)
    for number, (felt, planned) in enumerate(zip(up, _ups(recording.test), strict=True), start=1):
        if np.arccos(np.clip(felt @ planned, -1, 1)) <= LARGEST_TILT_OF_START:
            continue
        raise ValueError(
            f"`{name}` must have {_face(planned)} up in dwell {number}, got {_face(felt)} up by its accelerometers."
            f"{_other(recording, up, plan)}"
        )


def _turn(recording: Recording, start: Compensation, plan: Sequence[TurnTest], name: str) -> None:
    """Whether the gyros turned as planned."""
    turned = start.gyro_matrix @ recording.turned
    test = recording.test
    planned = test.axis * test.angle
    if _fits_turn(turned, planned):
        return
    forces = recording.forces @ start.accelerometer_matrix.T + start.accelerometer_bias
    hint = _other(recording, forces / np.linalg.norm(forces, axis=1, keepdims=True), plan)
    raise ValueError(_another_turn(recording, turned, name, hint))


def _another_turn(recording: Recording, turned: Array, name: str, hint: str) -> str:
    planned = recording.test.axis * recording.test.angle
    return (
        f"`{name}` must turn by {np.round(planned / DEG, 1).tolist()} deg about x, y, z, got "
        f"{np.round(turned / DEG, 1).tolist()} deg by its gyros.{hint}"
    )


def _fits_turn(turned: Array, planned: Array) -> bool:
    angle, wanted = np.linalg.norm(turned), np.linalg.norm(planned)
    off = np.arccos(np.clip(turned @ planned / max(angle * wanted, np.finfo(float).tiny), -1, 1))
    return bool(abs(angle - wanted) <= min(TURN_TOLERANCE * wanted, np.pi / 2) and off <= LARGEST_TILT_OF_START)


def _other(recording: Recording, up: Array, plan: Sequence[TurnTest]) -> str:
    """Sentence that names the tests of the plan which a recording fits, if any."""
    fitting = [
        test.label
        for test in plan
        if test.label != recording.test.label
        and (np.einsum("di,di->d", up, _ups(test)) >= np.cos(LARGEST_TILT_OF_START)).all()
        and _fits_turn(recording.turned, test.axis * test.angle)
    ]
    return f" It would fit test {' or '.join(fitting)}: are recordings in the order of the plan?" if fitting else ""


def _ups(test: TurnTest) -> Array:
    """Direction up in body axes in both dwells, shape (2, 3)."""
    return np.stack([test.C_b_n[2], test.C_b_n_end[2]])


def _face(up: Array) -> str:
    """Body axis nearest to a direction, with its sign."""
    i = int(np.argmax(np.abs(up)))
    return f"{'-' if up[i] < 0 else '+'}{AXES[i]}"
