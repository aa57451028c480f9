"""What integrating the angles, (6) and (7), costs near a vertical bow, where a matrix costs nothing."""

import numpy as np

from fogkit import checks
from fogkit.gyrocompass.frames import hull_attitude
from fogkit.gyrocompass.mechanisation import angle_rates
from fogkit.rotation import dcm_from_rotvec, small_angle_between


def over_the_top(closest: float, dt: float = 0.01, rate: float = 0.2) -> tuple[float, float]:
    """Error of attitude after a loop that takes the bow past the vertical, by angles and by a matrix.

    The hull turns at a constant rate about a level axis, its bow from north up and past the vertical at the angle
    `closest`, to the other horizon. The truth is one rotation.

    Parameters
    ----------
    closest : float
        Smallest angle between bow and vertical, rad.
    dt : float, optional
        Step, s.
    rate : float, optional
        Rate of turn, rad/s.

    Returns
    -------
    by_angles, by_matrix : float
        Angle between computed and true attitude at the end, rad: rates (6) integrated by the rule of Runge and Kutta of
        the fourth order, and a matrix turned by the same increments.
    """
    closest = checks.positive("closest", closest, "rad")
    dt, rate = checks.positive("dt", dt, "s"), checks.positive("rate", rate, "rad/s")
    omega = rate * np.array([np.sin(closest), 0.0, np.cos(closest)])
    steps = int(np.pi / rate / dt)
    angles, C = np.zeros(3), np.eye(3)
    for _ in range(steps):
        k_1 = angle_rates(omega, *angles[1:])
        k_2 = angle_rates(omega, *(angles + 0.5 * dt * k_1)[1:])
        k_3 = angle_rates(omega, *(angles + 0.5 * dt * k_2)[1:])
        k_4 = angle_rates(omega, *(angles + dt * k_3)[1:])
        angles = angles + dt / 6 * (k_1 + 2 * k_2 + 2 * k_3 + k_4)
        C = C @ dcm_from_rotvec(omega * dt)
    truth = dcm_from_rotvec(omega * steps * dt)
    turns = (small_angle_between(computed, truth) for computed in (hull_attitude(*angles), C))
    by_angles, by_matrix = (float(np.linalg.norm(turn)) for turn in turns)
    return by_angles, by_matrix
