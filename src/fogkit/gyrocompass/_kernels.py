"""Compiled parts of the gyrocompass: plain arrays in, plain arrays out, nothing checked.

States are in the order of (10) of the thesis: heading, trim, roll; velocity north, up, east; latitude, longitude,
height; biases of the gyros x, y, z; their scale factors.
"""

import math

import numpy as np
from numba import njit

from fogkit.constants import EARTH_RATE


@njit(cache=True, nogil=True)
def system_matrix(state, rates, force, mount_angle, mount_rate, axes, radius, gravity, F):
    """Write the matrix of the linear error model into F, shape (15, 15).

    `state` is that of `CompassState.to_vector`, `axes` the matrix ``C_p_m``, `radius` and `gravity` those of the place.
    """
    sK, cK = math.sin(state[0]), math.cos(state[0])
    st, ct = math.sin(state[1]), math.cos(state[1])
    sr, cr = math.sin(state[2]), math.cos(state[2])
    sb, cb = math.sin(mount_angle), math.cos(mount_angle)
    vn, vu, ve = state[3], state[4], state[5]
    sl, cl = math.sin(state[6]), math.cos(state[6])
    tt, tl, inv = st / ct, sl / cl, 1.0 / radius
    F[:, :] = 0.0

    # rate of the hull against inertial space; of north-up-east, and that in the axes turned by heading
    mx = axes[0, 0] * rates[0] + axes[0, 1] * rates[1] + axes[0, 2] * rates[2]
    wy = axes[1, 0] * rates[0] + axes[1, 1] * rates[1] + axes[1, 2] * rates[2] - mount_rate
    mz = axes[2, 0] * rates[0] + axes[2, 1] * rates[1] + axes[2, 2] * rates[2]
    wz = cb * mz - sb * mx
    oN, oE = EARTH_RATE * cl + ve * inv, -vn * inv
    ahead, abeam = oN * cK + oE * sK, -oN * sK + oE * cK
    level, across = wy * cr - wz * sr, wy * sr + wz * cr
    turn = EARTH_RATE * cl + ve * inv / (cl * cl)  # what the rate about up changes by per latitude

    F[0, 0] = -tt * abeam
    F[0, 1] = -(level * st + ahead) / (ct * ct)
    F[0, 2] = across / ct
    F[0, 3] = tt * sK * inv
    F[0, 5] = (tl - tt * cK) * inv
    F[0, 6] = tt * cK * EARTH_RATE * sl + turn
    F[0, 8] = (tt * (cK * ve - sK * vn) - tl * ve) * inv * inv
    F[1, 0] = ahead
    F[1, 2] = level
    F[1, 3] = cK * inv
    F[1, 5] = sK * inv
    F[1, 6] = -sK * EARTH_RATE * sl
    F[1, 8] = -(sK * ve + cK * vn) * inv * inv
    F[2, 0] = -abeam / ct
    F[2, 1] = -(level + ahead * st) / (ct * ct)
    F[2, 2] = tt * across
    F[2, 3] = sK * inv / ct
    F[2, 5] = -cK * inv / ct
    F[2, 6] = cK * EARTH_RATE * sl / ct
    F[2, 8] = (cK * ve - sK * vn) * inv * inv / ct
    for j in range(3):
        x, y = cb * axes[0, j] + sb * axes[2, j], axes[1, j]
        z = cb * axes[2, j] - sb * axes[0, j]
        down = z * sr - y * cr
        F[0, 9 + j] = down / ct
        F[1, 9 + j] = y * sr + z * cr
        F[2, 9 + j] = x + tt * down
        for i in range(3):
            F[i, 12 + j] = F[i, 9 + j] * rates[j]

    # specific force in the axes turned by heading and trim, by heading, and not turned at all
    fy, fz = force[1] * cr - force[2] * sr, force[1] * sr + force[2] * cr
    f_ahead, f_up = force[0] * ct - fy * st, force[0] * st + fy * ct
    F[3, 0] = -(f_ahead * sK + fz * cK)
    F[5, 0] = f_ahead * cK - fz * sK
    F[3, 1] = -f_up * cK
    F[4, 1] = f_ahead
    F[5, 1] = -f_up * sK
    F[3, 2] = fz * st * cK - fy * sK
    F[4, 2] = -fz * ct
    F[5, 2] = fz * st * sK + fy * cK
    F[3, 3] = -vu * inv
    F[3, 4] = -vn * inv
    F[3, 5] = -2.0 * (EARTH_RATE * sl + ve * tl * inv)
    F[3, 6] = -ve * (2.0 * EARTH_RATE * cl + ve * inv / (cl * cl))
    F[3, 8] = (ve * ve * tl + vn * vu) * inv * inv
    F[4, 3] = 2.0 * vn * inv
    F[4, 5] = 2.0 * (EARTH_RATE * cl + ve * inv)
    F[4, 6] = -2.0 * EARTH_RATE * sl * ve
    F[4, 8] = 2.0 * gravity * inv - (vn * vn + ve * ve) * inv * inv
    F[5, 3] = 2.0 * EARTH_RATE * sl + ve * tl * inv
    F[5, 4] = -(2.0 * EARTH_RATE * cl + ve * inv)
    F[5, 5] = (vn * tl - vu) * inv
    F[5, 6] = 2.0 * EARTH_RATE * (sl * vu + cl * vn) + ve * vn * inv / (cl * cl)
    F[5, 8] = (ve * vu - ve * vn * tl) * inv * inv

    F[6, 3] = inv
    F[6, 8] = -vn * inv * inv
    F[7, 5] = inv / cl
    F[7, 6] = ve * tl * inv / cl
    F[7, 8] = -ve * inv * inv / cl
    F[8, 4] = 1.0


@njit(cache=True, nogil=True)
def covariance_step(P, F, dt, angle_noise, force_noise, walks, M):
    """Advance the covariance P, shape (15, 15), by a step, in place; M is scratch of the same shape.

    The transition is the exponential to second order. `angle_noise` and `force_noise`, shape (3, 3), are spectral
    densities in the rows of angles and of velocity; `walks`, shape (15,), those of random walks of the states.
    """
    for i in range(9):
        for k in range(15):
            M[i, k] = 0.5 * dt * F[i, k]
        M[i, i] += 1.0
    # Phi = I + dt (I + F dt/2) F; rows of the biases and scale factors are those of the unit matrix
    Phi = np.zeros((9, 15))
    for i in range(9):
        for k in range(9):
            f = dt * M[i, k]
            if f != 0.0:
                for j in range(15):
                    Phi[i, j] += f * F[k, j]
        Phi[i, i] += 1.0
    for i in range(9):
        for j in range(15):
            M[i, j] = 0.0
        for k in range(15):
            f = Phi[i, k]
            if f != 0.0:
                for j in range(15):
                    M[i, j] += f * P[k, j]
    for i in range(9):
        for j in range(i + 1):
            total = 0.0
            for k in range(15):
                total += M[i, k] * Phi[j, k]
            P[i, j] = total
            P[j, i] = total
        for j in range(9, 15):
            P[i, j] = M[i, j]
            P[j, i] = M[i, j]
    for i in range(3):
        for j in range(3):
            P[i, j] += dt * angle_noise[i, j]
            P[3 + i, 3 + j] += dt * force_noise[i, j]
    for i in range(15):
        P[i, i] += dt * walks[i]


@njit(cache=True, nogil=True)
def covariance_update(P, row, variance):
    """Measure a state with a variance: update P in place. Return the variance of the innovation."""
    S = P[row, row] + variance
    column = P[:, row].copy()
    for i in range(15):
        gain = column[i] / S
        for j in range(i + 1):
            value = P[i, j] - gain * column[j]
            P[i, j] = value
            P[j, i] = value
    return S


@njit(cache=True, nogil=True)
def covariance_run(
    P,  # covariance at the start, shape (15, 15); that at the end on return
    states,  # CompassState.to_vector at each step, shape (n, 9)
    rates,  # of the gyros, shape (n, 3)
    force,  # specific force in the hull, shape (n, 3)
    mount_angle,  # shape (n,)
    mount_rate,  # shape (n,)
    axes,  # C_p_m, shape (3, 3)
    earth_radius,
    gravity,  # on the sphere
    dt,
    gyro_density,  # of the gyros' white noise, shape (3,)
    force_density,  # of the accelerometers' white noise
    walks,  # shape (15,)
    aided,  # which of the states are measured, shape (m,)
    variances,  # of the measurements, shape (m,)
    every,  # steps from one measurement to the next; 0: none
    keep,  # steps from one row of the output to the next
    out,  # standard deviations, shape (n // keep + 1, 15)
):
    """Covariance of the linear error model along a motion. Return the step where it ceased to be one, or -1."""
    F, M = np.empty((15, 15)), np.empty((15, 15))
    angle_noise, force_noise = np.zeros((3, 3)), np.zeros((3, 3))
    n = states.shape[0] - 1
    for i in range(3):
        force_noise[i, i] = force_density
    for step in range(n + 1):
        if every > 0 and step % every == 0:
            for k in range(aided.shape[0]):
                covariance_update(P, aided[k], variances[k])
        if step % keep == 0:
            for i in range(15):
                if not P[i, i] >= 0.0:
                    return step
                out[step // keep, i] = math.sqrt(P[i, i])
        if step == n:
            break
        # the middle of the step: second order, as the transition is
        now, after = states[step], states[step + 1]
        state = 0.5 * (now + after)
        radius = earth_radius + state[8]
        there = gravity * (earth_radius / radius) * (earth_radius / radius)
        angle, rate = 0.5 * (mount_angle[step] + mount_angle[step + 1]), 0.5 * (mount_rate[step] + mount_rate[step + 1])
        turned, pushed = 0.5 * (rates[step] + rates[step + 1]), 0.5 * (force[step] + force[step + 1])
        system_matrix(state, turned, pushed, angle, rate, axes, radius, there, F)
        for i in range(3):
            for j in range(3):
                total = 0.0
                for k in range(3):
                    total += F[i, 9 + k] * F[j, 9 + k] * gyro_density[k]
                angle_noise[i, j] = total
        covariance_step(P, F, dt, angle_noise, force_noise, walks, M)
    return -1
