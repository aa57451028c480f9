"""Compiled loop of the thesis's filter, with the 15 states of `fogkit.gyrocompass.error_model.STATES`.

Mechanisation and covariance are predicted in every step of the record.
"""

import math

import numpy as np
from numba import njit

from fogkit.constants import EARTH_RATE
from fogkit.gyrocompass import _kernels as compass
from fogkit.gyrocompass.filters import _kernels as steps


@njit(cache=True, nogil=True, error_model="numpy")
def angles_of(C, angles):
    """Heading, trim and roll of the hull."""
    angles[0] = math.atan2(C[2, 0], C[0, 0])
    angles[1] = math.asin(min(1.0, max(-1.0, C[1, 0])))
    angles[2] = math.atan2(-C[1, 2], C[1, 1])


@njit(cache=True, nogil=True, error_model="numpy")
def set_attitude(angles, C):
    """Attitude C_h_g of heading, trim and roll."""
    sK, cK = math.sin(angles[0]), math.cos(angles[0])
    st, ct = math.sin(angles[1]), math.cos(angles[1])
    sr, cr = math.sin(angles[2]), math.cos(angles[2])
    C[0, 0], C[0, 1], C[0, 2] = cK * ct, -cK * st * cr - sK * sr, cK * st * sr - sK * cr
    C[1, 0], C[1, 1], C[1, 2] = st, ct * cr, -ct * sr
    C[2, 0], C[2, 1], C[2, 2] = sK * ct, -sK * st * cr + cK * sr, sK * st * sr + cK * cr


@njit(cache=True, nogil=True, error_model="numpy")
def extended_run(
    P,  # covariance at the start, shape (15, 15); that at the end on return
    C,  # C_h_g at the start, shape (3, 3); in place
    s,  # velocity, lat, lon, alt, biases, scale factors: the other 12 quantities; in place
    dtheta,  # of the gyros, shape (n, 3)
    dv,  # of the accelerometers, in the hull, shape (n, 3)
    mount,  # angle of the mount at the ends of the steps, shape (n + 1,)
    axes,  # C_p_m, shape (3, 3)
    earth_radius,
    gravity,
    dt,
    gyro_density,  # shape (3,)
    force_density,
    walks,  # shape (15,)
    fix_steps,  # steps before which a measurement is taken, ascending, shape (m,)
    fixes,  # velocity north, up, east, lat, lon, alt, shape (m, 6); NaN: not measured
    variances,  # shape (6,)
    margins,  # of trim and latitude from a right angle, shape (2,)
    keep,  # steps from one row of the output to the next
    states_out,  # angles and s, shape (n // keep + 1, 15)
    P_out,  # shape (n // keep + 1, 15, 15)
    nis,  # normalised innovations squared, shape (m,)
):
    """The thesis's filter: 15 errors about the computed state, fed back after each measurement."""
    n = dtheta.shape[0]
    F, M, h, K, x = np.empty((15, 15)), np.empty((15, 15)), np.zeros(15), np.empty(15), np.zeros(15)
    state, angles, after, rates, hull = np.empty(9), np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    frame, coriolis, force, scratch, mean = np.zeros(3), np.zeros(3), np.empty(3), np.empty(3), np.empty(3)
    angle_noise, force_noise, R = np.zeros((3, 3)), np.zeros((3, 3)), np.empty((3, 3))
    for i in range(3):
        force_noise[i, i] = force_density
    fix = 0
    for step in range(n + 1):
        while fix < fix_steps.shape[0] and fix_steps[fix] == step:
            nis[fix] = steps.measure(P, x, s, fixes[fix], variances, h, K, M)
            if nis[fix] < 0.0:
                return steps.NOT_A_COVARIANCE, step
            angles_of(C, angles)
            for i in range(3):
                angles[i] -= x[i]
            set_attitude(angles, C)
            for i in range(6):
                s[i] -= x[3 + i]
                s[6 + i] += x[9 + i]
            fix += 1
        angles_of(C, angles)
        if math.pi / 2 - abs(angles[1]) < margins[0]:
            return steps.BOW_VERTICAL, step
        if math.pi / 2 - abs(s[3]) < margins[1]:
            return steps.AT_A_POLE, step
        if step % keep == 0:
            for i in range(15):
                if not P[i, i] >= 0.0:
                    return steps.NOT_A_COVARIANCE, step
                states_out[step // keep, i] = angles[i] if i < 3 else s[i - 3]
                for j in range(15):
                    P_out[step // keep, i, j] = P[i, j]
        if step == n:
            break
        radius = earth_radius + s[5]
        weight = gravity * (earth_radius / radius) ** 2
        steps.hull_turn(dtheta[step], s[6:9], s[9:12], mount[step], mount[step + 1], axes, dt, rates, hull)
        for i in range(3):
            rates[i] /= dt
            mean[i] = dv[step, i] / dt
        sl, cl = math.sin(s[3]), math.cos(s[3])
        frame[0] = EARTH_RATE * cl + s[2] / radius
        frame[1] = EARTH_RATE * sl + s[2] * sl / cl / radius
        frame[2] = -s[0] / radius
        coriolis[0], coriolis[1] = frame[0] + EARTH_RATE * cl, frame[1] + EARTH_RATE * sl
        coriolis[2] = frame[2]
        north, up, east = s[0], s[1], s[2]
        steps.advance(C, hull, dv[step], frame, dt, force, scratch, R)
        s[0] += dt * (force[0] - coriolis[1] * east + coriolis[2] * up)
        s[1] += dt * (force[1] - coriolis[2] * north + coriolis[0] * east - weight)
        s[2] += dt * (force[2] - coriolis[0] * up + coriolis[1] * north)
        angles_of(C, after)
        for i in range(3):  # the middle of the step
            way = after[i] - angles[i]
            if way > math.pi:
                way -= 2 * math.pi
            elif way < -math.pi:
                way += 2 * math.pi
            state[i] = angles[i] + 0.5 * way
            state[6 + i] = s[3 + i]
        state[3], state[4], state[5] = 0.5 * (north + s[0]), 0.5 * (up + s[1]), 0.5 * (east + s[2])
        angle, rate = 0.5 * (mount[step] + mount[step + 1]), (mount[step + 1] - mount[step]) / dt
        compass.system_matrix(state, rates, mean, angle, rate, axes, radius, weight, F)
        for i in range(3):
            for j in range(3):
                angle_noise[i, j] = 0.0
                for k in range(3):
                    angle_noise[i, j] += F[i, 9 + k] * F[j, 9 + k] * gyro_density[k]
        compass.covariance_step(P, F, dt, angle_noise, force_noise, walks, M)
        s[3] += 0.5 * (north + s[0]) / radius * dt
        s[4] += 0.5 * (east + s[2]) / (radius * cl) * dt
        s[5] += 0.5 * (up + s[1]) * dt
    return steps.FINISHED, n
