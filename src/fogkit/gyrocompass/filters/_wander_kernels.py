"""Compiled loop of the filter with the Earth's axis for a state (`fogkit.gyrocompass.filters.wander`), of 17 states.

Mechanisation and covariance are predicted in every step of the record.
"""

import math

import numpy as np
from numba import njit

from fogkit.constants import EARTH_RATE
from fogkit.gyrocompass.filters import _kernels as steps

MANOEUVRE = 5.0
"""Standard deviations of level specific force, by tilts and noise, from which it counts as one of a manoeuvre."""

UNDER_WAY = 5.0
"""Standard deviations of velocity from which it counts as one that turns with the hull."""


@njit(cache=True, nogil=True, error_model="numpy")
def unit(x, y):
    """Direction of a vector of two; the first axis if it has none."""
    length = math.sqrt(x * x + y * y)
    if length < 1e-12:
        return 1.0, 0.0
    return x / length, y / length


@njit(cache=True, nogil=True, error_model="numpy")
def turn_rate(C, hull, frame, up, dt):
    """Rate of heading, clockwise, by (6) of the thesis; 0 with the bow near the vertical, where it has none.

    `hull` is the turn in a step, `frame` the rate of w and `up` the rate about up of north and east.
    """
    square = 1.0 - C[1, 0] * C[1, 0]
    if square < 0.01:
        return 0.0
    rate = 0.0
    for i in range(1, 3):
        own = hull[i] / dt - (C[0, i] * frame[0] + C[1, i] * up + C[2, i] * frame[2])
        rate -= own * C[1, i] / square
    return rate


@njit(cache=True, nogil=True, error_model="numpy")
def wander_matrix(C, s, force, pushed, yaw, rates, mount_angle, axes, radius, weight, F):
    """Error model of `fogkit.gyrocompass.filters.wander_model`: write F, shape (17, 17).

    `s` is velocity north, up, east; latitude, longitude, height; the axis 1 and 2 and what the model does not need;
    `force` is in w; unless the vessel is `pushed` its level part is that of the Coriolis force and of a turn of the
    velocity with `yaw`, clockwise, rad/s.
    """
    inv, U = 1.0 / radius, EARTH_RATE
    north, up, east = s[0], s[1], s[2]
    sl, cl = math.sin(s[3]), math.cos(s[3])
    e0, e2, tl = s[6] / cl, s[7] / cl, sl / cl
    v0, v2 = north * e0 - east * e2, north * e2 + east * e0
    w0, w1, w2 = U * s[6] + v2 * inv, U * sl, U * s[7] - v0 * inv
    for i in range(17):
        for j in range(17):
            F[i, j] = 0.0
    F[0, 1], F[0, 2] = w2, -w1
    F[1, 0], F[1, 2] = -w2, w0
    F[2, 0], F[2, 1] = w1, -w0
    F[0, 3], F[0, 5], F[0, 6], F[0, 8] = -e2 * inv, -e0 * inv, -v2 * tl * inv, v2 * inv * inv
    F[2, 3], F[2, 5], F[2, 6], F[2, 8] = e0 * inv, -e2 * inv, v0 * tl * inv, -v0 * inv * inv
    F[0, 9], F[0, 10] = -U - east / cl * inv, -north / cl * inv
    F[1, 6] = -U * cl
    F[2, 9], F[2, 10] = north / cl * inv, -U - east / cl * inv
    F[6, 3], F[6, 8] = inv, -north * inv * inv
    F[7, 5], F[7, 6], F[7, 8] = inv / cl, east * tl * inv / cl, -east * inv * inv / cl
    F[8, 4] = 1.0
    F[9, 3], F[9, 5], F[9, 6], F[9, 8] = -e0 * sl * inv, e2 * sl * inv, -v0 * inv / cl, v0 * sl * inv * inv
    F[9, 9], F[9, 10] = -north * tl * inv, east * tl * inv
    F[10, 3], F[10, 5], F[10, 6], F[10, 8] = -e2 * sl * inv, -e0 * sl * inv, -v2 * inv / cl, v2 * sl * inv * inv
    F[10, 9], F[10, 10] = -east * tl * inv, -north * tl * inv

    # Coriolis force, north, up, east, and its derivatives; east * tl / R is the turn of the meridian
    a1, slope = 2.0 * U * sl + east * tl * inv, 2.0 * U * cl + east * inv / (cl * cl)
    n0 = a1 * east + north * up * inv
    n2 = (2.0 * U * cl + east * inv) * up - a1 * north
    n0, n2 = n0 - yaw * east, n2 + yaw * north
    F[4, 3], F[4, 5] = 2.0 * north * inv, 2.0 * (U * cl + east * inv)
    F[4, 6] = -2.0 * U * sl * east
    F[4, 8] = 2.0 * weight * inv - (north * north + east * east) * inv * inv
    F[4, 0], F[4, 2] = -force[2], force[0]
    m0, m2 = e0, e2
    if not pushed:
        m0, m2 = unit(e0, e2)
    for column in (3, 4, 5, 6, 8):
        if column == 3:
            b0, b2 = up * inv, yaw - a1
        elif column == 4:
            b0, b2 = north * inv, 2.0 * U * cl + east * inv
        elif column == 5:
            b0, b2 = a1 + east * tl * inv - yaw, (up - north * tl) * inv
        elif column == 6:
            b0, b2 = slope * east + n0 * tl, -2.0 * U * sl * up - slope * north + n2 * tl
        else:
            b0 = -(east * east * tl + north * up) * inv * inv
            b2 = -(east * up - east * north * tl) * inv * inv
        c0, c2 = b0 * e0 - b2 * e2, b0 * e2 + b2 * e0
        F[3, column] = -(m0 * c0 + m2 * c2)
        F[5, column] = m2 * c0 - m0 * c2
    F[3, 5] -= yaw
    F[5, 3] += yaw
    F[3, 9], F[3, 10] = -(m0 * n0 + m2 * n2) / cl, (m0 * n2 - m2 * n0) / cl
    F[5, 9], F[5, 10] = -F[3, 10], F[3, 9]
    F[3, 0], F[3, 1], F[3, 2] = m2 * force[1], m0 * force[2] - m2 * force[0], -m0 * force[1]
    F[5, 0], F[5, 1], F[5, 2] = m0 * force[1], -m2 * force[2] - m0 * force[0], m2 * force[1]
    if pushed:
        q0, q2 = force[0] - n0 * e0 + n2 * e2, force[2] - n0 * e2 - n2 * e0
        F[3, 6] += tl * (m0 * q0 + m2 * q2)
        F[5, 6] += tl * (m0 * q2 - m2 * q0)
        F[3, 9] += q0 / cl
        F[3, 10] += q2 / cl
        F[5, 9] += q2 / cl
        F[5, 10] -= q0 / cl

    cb, sb = math.cos(mount_angle), math.sin(mount_angle)
    for j in range(3):
        x, y = cb * axes[0, j] + sb * axes[2, j], axes[1, j]
        z = cb * axes[2, j] - sb * axes[0, j]
        for i in range(3):
            F[i, 11 + j] = C[i, 0] * x + C[i, 1] * y + C[i, 2] * z
            F[i, 14 + j] = F[i, 11 + j] * rates[j]


@njit(cache=True, nogil=True, error_model="numpy")
def wander_run(
    P,  # covariance at the start, shape (17, 17); that at the end on return
    C,  # C_h_w at the start, shape (3, 3); in place
    s,  # velocity, lat, lon, alt, axis 1, axis 2, biases, scale factors: shape (14,); in place
    dtheta,
    dv,
    mount,
    axes,
    earth_radius,
    gravity,
    dt,
    gyro_density,
    force_density,
    walks,  # shape (17,)
    fix_steps,
    fixes,
    variances,
    margins,
    keep,
    C_out,  # shape (n // keep + 1, 3, 3)
    states_out,  # s, shape (n // keep + 1, 14)
    P_out,  # shape (n // keep + 1, 17, 17)
    nis,
    follows,  # whether velocity turns with the hull
    smooth,  # whether to write what a smoother needs, in each row of the output:
    Phi_out,  # transitions to the next row, shape (n // keep, 17, 17)
    before_out,  # covariances there before the measurement
    x_out,  # corrections by the measurement, shape (n // keep + 1, 17)
):
    """The filter with the Earth's axis for a state; arguments as those of `_extended_kernels.extended_run`."""
    n, moving = dtheta.shape[0], 11
    F, M, h, K, x = np.empty((17, 17)), np.empty((17, 17)), np.zeros(17), np.empty(17), np.zeros(17)
    Phi, T, N = np.empty((moving, 17)), np.empty((moving, 17)), np.empty((17, moving))
    total = np.zeros((17, 17))
    for i in range(17):
        total[i, i] = 1.0
    rates, hull, frame = np.empty(3), np.empty(3), np.zeros(3)
    force, scratch, before, R = np.zeros(3), np.empty(3), np.empty((3, 3)), np.empty((3, 3))
    fix = 0
    for step in range(n + 1):
        if smooth and step % keep == 0 and step > 0:
            for i in range(17):
                for j in range(17):
                    Phi_out[step // keep - 1, i, j], before_out[step // keep - 1, i, j] = total[i, j], P[i, j]
                    total[i, j] = 1.0 if i == j else 0.0
        while fix < fix_steps.shape[0] and fix_steps[fix] == step:
            nis[fix] = steps.measure(P, x, s, fixes[fix], variances, h, K, M)
            if nis[fix] < 0.0:
                return steps.NOT_A_COVARIANCE, step
            for i in range(3):
                scratch[i] = -x[i]
            for i in range(8):
                s[i] -= x[3 + i]
            steps.turn_left(C, scratch, R)
            for i in range(8, 14):
                s[i] += x[3 + i]
            if smooth:
                for i in range(17):
                    x_out[step // keep, i] += x[i]
            fix += 1
        if math.pi / 2 - abs(s[3]) < margins[1]:
            return steps.AT_A_POLE, step
        if step % keep == 0:
            for i in range(17):
                if not P[i, i] >= 0.0:
                    return steps.NOT_A_COVARIANCE, step
                for j in range(17):
                    P_out[step // keep, i, j] = P[i, j]
            for i in range(3):
                for j in range(3):
                    C_out[step // keep, i, j] = C[i, j]
            for i in range(14):
                states_out[step // keep, i] = s[i]
        if step == n:
            break
        radius = earth_radius + s[5]
        weight = gravity * (earth_radius / radius) ** 2
        steps.hull_turn(dtheta[step], s[8:11], s[11:14], mount[step], mount[step + 1], axes, dt, rates, hull)
        north, up, east = s[0], s[1], s[2]
        sl, cl = math.sin(s[3]), math.cos(s[3])
        e0, e2 = s[6] / cl, s[7] / cl
        v0, v2 = north * e0 - east * e2, north * e2 + east * e0
        frame[0], frame[1] = EARTH_RATE * s[6] + v2 / radius, EARTH_RATE * sl
        frame[2] = EARTH_RATE * s[7] - v0 / radius
        for i in range(3):
            rates[i] /= dt
            for j in range(3):
                before[i, j] = C[i, j]
        yaw = 0.0
        if follows and north * north + east * east > UNDER_WAY * UNDER_WAY * (P[3, 3] + P[5, 5]):
            yaw = turn_rate(C, hull, frame, frame[1] + east * sl / cl / radius, dt)
        angle = 0.5 * (mount[step] + mount[step + 1])
        steps.advance(C, hull, dv[step], frame, dt, force, scratch, R)
        a1 = 2.0 * EARTH_RATE * sl + east * sl / cl / radius
        c0 = a1 * east + north * up / radius
        c2 = (2.0 * EARTH_RATE * cl + east / radius) * up - a1 * north
        c0, c2 = c0 - yaw * east, c2 + yaw * north
        f0, f2 = force[0] - (c0 * e0 - c2 * e2), force[2] - (c0 * e2 + c2 * e0)
        rise = force[1] - weight + (north * north + east * east) / radius + 2.0 * EARTH_RATE * cl * east
        # a force that tilts, noise and the turn of the Coriolis force explain is theirs: taken for one of a manoeuvre
        # it would be knowledge of north
        noise = weight * weight * (P[0, 0] + P[2, 2]) + 2.0 * force_density / dt
        noise += (c0 * c0 + c2 * c2) * (P[9, 9] + P[10, 10]) / (cl * cl)
        pushed = f0 * f0 + f2 * f2 > MANOEUVRE * MANOEUVRE * noise
        m0, m2 = e0, e2
        if pushed and yaw != 0.0:  # another manoeuvre than a turn
            f0, f2 = f0 - yaw * (east * e0 + north * e2), f2 - yaw * (east * e2 - north * e0)
            yaw = 0.0
        if not pushed:
            m0, m2 = unit(e0, e2)
            force[0], force[1], force[2] = force[0] - f0, weight, force[2] - f2
        wander_matrix(before, s, force, pushed, yaw, rates, angle, axes, radius, weight, F)
        steps.propagate(P, F, dt, moving, Phi, T, N)
        for i in range(3):
            for j in range(3):
                for k in range(3):
                    P[i, j] += dt * F[i, 11 + k] * F[j, 11 + k] * gyro_density[k]
            P[3 + i, 3 + i] += dt * force_density
        for i in range(17):
            P[i, i] += dt * walks[i]
        if smooth:
            steps.chain(Phi, total, T)
        s[0] += dt * (m0 * f0 + m2 * f2 - yaw * east)
        s[1] += dt * rise
        s[2] += dt * (m0 * f2 - m2 * f0 + yaw * north)
        north, east = 0.5 * (north + s[0]), 0.5 * (east + s[2])
        s[3] += north / radius * dt
        s[4] += east / (cl * radius) * dt
        s[5] += 0.5 * (up + s[1]) * dt
        s[6] -= (north * e0 - east * e2) * sl / radius * dt
        s[7] -= (north * e2 + east * e0) * sl / radius * dt
    return steps.FINISHED, n
