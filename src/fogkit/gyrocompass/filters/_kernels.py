"""Compiled loops of the two filters: plain arrays in, plain arrays out, nothing checked.

`extended_run` has the 15 states of the thesis (`fogkit.gyrocompass.error_model.STATES`); `wander_run` the 17 of
`fogkit.gyrocompass.filters.wander`. Both predict mechanisation and covariance in every step of the record.
"""

import math

import numpy as np
from numba import njit

from fogkit.constants import EARTH_RATE
from fogkit.gyrocompass import _kernels as compass

MANOEUVRE = 5.0
"""Standard deviations of level specific force, by tilts and noise, from which it counts as one of a manoeuvre."""

UNDER_WAY = 5.0
"""Standard deviations of velocity from which it counts as one that turns with the hull."""

FINISHED, NOT_A_COVARIANCE, BOW_VERTICAL, AT_A_POLE = 0, 1, 2, 3


@njit(cache=True, nogil=True)
def turn(C, r, before):
    """Multiply C by the rotation of the vector r, in place: from the left if `before`, else from the right."""
    square = r[0] * r[0] + r[1] * r[1] + r[2] * r[2]
    if square < 1e-4:
        s, c = 1.0 - square / 6.0 * (1.0 - square / 20.0), 0.5 - square / 24.0 * (1.0 - square / 30.0)
    else:
        angle = math.sqrt(square)
        s, c = math.sin(angle) / angle, (1.0 - math.cos(angle)) / square
    x, y, z = r[0], r[1], r[2]
    a, b, d = 1.0 - c * (y * y + z * z), c * x * y - s * z, c * x * z + s * y
    e, f, g = c * x * y + s * z, 1.0 - c * (x * x + z * z), c * y * z - s * x
    h, i, j = c * x * z - s * y, c * y * z + s * x, 1.0 - c * (x * x + y * y)
    for k in range(3):
        if before:
            u, v, w = C[0, k], C[1, k], C[2, k]
            C[0, k], C[1, k], C[2, k] = a * u + b * v + d * w, e * u + f * v + g * w, h * u + i * v + j * w
        else:
            u, v, w = C[k, 0], C[k, 1], C[k, 2]
            C[k, 0], C[k, 1], C[k, 2] = a * u + e * v + h * w, b * u + f * v + i * w, d * u + g * v + j * w


@njit(cache=True, nogil=True)
def hull_turn(dtheta, bias, scale, before, after, axes, dt, compensated, hull):
    """Increments of the gyros, compensated, and the turn of the hull that follows from them and the mount's angles."""
    for j in range(3):
        compensated[j] = (dtheta[j] - bias[j] * dt) / (1.0 + scale[j])
    way, middle = after - before, 0.5 * (after + before)
    sinc = 1.0 - way * way / 24.0 * (1.0 - way * way / 80.0)
    m0 = (axes[0, 0] * compensated[0] + axes[0, 1] * compensated[1] + axes[0, 2] * compensated[2]) / sinc
    m2 = (axes[2, 0] * compensated[0] + axes[2, 1] * compensated[1] + axes[2, 2] * compensated[2]) / sinc
    cb, sb = math.cos(middle), math.sin(middle)
    hull[0] = cb * m0 + sb * m2
    hull[1] = axes[1, 0] * compensated[0] + axes[1, 1] * compensated[1] + axes[1, 2] * compensated[2] - way
    hull[2] = cb * m2 - sb * m0


@njit(cache=True, nogil=True)
def advance(C, hull, dv, frame, dt, force, scratch):
    """Attitude over a step, in a frame that turns with the rate `frame`.

    `force`, the mean specific force in the frame, is written. The specific force is taken at the middle of the turn.
    """
    x, y, z = 0.5 * hull[0], 0.5 * hull[1], 0.5 * hull[2]
    p0, p1, p2 = dv[0] + y * dv[2] - z * dv[1], dv[1] + z * dv[0] - x * dv[2], dv[2] + x * dv[1] - y * dv[0]
    for i in range(3):
        scratch[i] = (C[i, 0] * p0 + C[i, 1] * p1 + C[i, 2] * p2) / dt
    half = 0.5 * dt  # the frame turns as well
    force[0] = scratch[0] - half * (frame[1] * scratch[2] - frame[2] * scratch[1])
    force[1] = scratch[1] - half * (frame[2] * scratch[0] - frame[0] * scratch[2])
    force[2] = scratch[2] - half * (frame[0] * scratch[1] - frame[1] * scratch[0])
    for i in range(3):
        scratch[i] = -frame[i] * dt
    turn(C, hull, False)
    turn(C, scratch, True)


@njit(cache=True, nogil=True)
def joseph(P, x, h, z, variance, K, M):
    """Scalar measurement ``z = h x + noise`` in Joseph's form, in place. Return the variance of the innovation.

    ``(I - K h) P (I - K h)^T + K r K^T`` is a sum of two squares, so that rounding cannot make it indefinite by more
    than its own size. K and M are scratch.
    """
    n = P.shape[0]
    S, innovation = variance, z
    for i in range(n):
        K[i] = 0.0
        for j in range(n):
            K[i] += P[i, j] * h[j]
        innovation -= h[i] * x[i]
    for i in range(n):
        S += h[i] * K[i]
    if not S > 0.0:
        return S
    for i in range(n):
        gain = K[i] / S
        x[i] += gain * innovation
        left = 0.0
        for j in range(n):
            M[i, j] = P[i, j] - gain * K[j]
            left += M[i, j] * h[j]
        for j in range(n):
            M[i, j] += (variance * gain - left) * K[j] / S
    for i in range(n):
        for j in range(i + 1):
            P[i, j] = 0.5 * (M[i, j] + M[j, i])
            P[j, i] = P[i, j]
    return S


@njit(cache=True, nogil=True)
def propagate(P, F, dt, moving, Phi, T, N):
    """Advance P by the exponential of F to second order; only the first `moving` rows of F are not zero.

    Phi, shape (moving, n), is written; T and N are scratch of shapes (moving, n) and (n, moving).
    """
    n = P.shape[0]
    for i in range(moving):
        for j in range(n):
            Phi[i, j] = dt * F[i, j]
        for k in range(moving):
            f = 0.5 * dt * dt * F[i, k]
            if f != 0.0:
                for j in range(n):
                    Phi[i, j] += f * F[k, j]
        Phi[i, i] += 1.0
    for i in range(moving):
        for j in range(n):
            T[i, j] = 0.0
        for k in range(n):
            f = Phi[i, k]
            if f != 0.0:
                for j in range(n):
                    T[i, j] += f * P[k, j]
    for i in range(moving):  # first the columns of what does not move, then the square of what does
        for j in range(moving, n):
            P[i, j] = T[i, j]
            P[j, i] = T[i, j]
        for j in range(n):
            N[j, i] = T[i, j]
    for i in range(moving):
        for j in range(i + 1):
            P[i, j] = 0.0
        for k in range(n):
            f = Phi[i, k]
            if f != 0.0:
                for j in range(i + 1):
                    P[i, j] += f * N[k, j]
        for j in range(i + 1):
            P[j, i] = P[i, j]


@njit(cache=True, nogil=True)
def angles_of(C, angles):
    """Heading, trim and roll of the hull."""
    angles[0] = math.atan2(C[2, 0], C[0, 0])
    angles[1] = math.asin(min(1.0, max(-1.0, C[1, 0])))
    angles[2] = math.atan2(-C[1, 2], C[1, 1])


@njit(cache=True, nogil=True)
def set_attitude(angles, C):
    """Attitude C_h_g of heading, trim and roll."""
    sK, cK = math.sin(angles[0]), math.cos(angles[0])
    st, ct = math.sin(angles[1]), math.cos(angles[1])
    sr, cr = math.sin(angles[2]), math.cos(angles[2])
    C[0, 0], C[0, 1], C[0, 2] = cK * ct, -cK * st * cr - sK * sr, cK * st * sr - sK * cr
    C[1, 0], C[1, 1], C[1, 2] = st, ct * cr, -ct * sr
    C[2, 0], C[2, 1], C[2, 2] = sK * ct, -sK * st * cr + cK * sr, sK * st * sr + cK * cr


@njit(cache=True, nogil=True)
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
    angle_noise, force_noise = np.zeros((3, 3)), np.zeros((3, 3))
    for i in range(3):
        force_noise[i, i] = force_density
    fix = 0
    for step in range(n + 1):
        while fix < fix_steps.shape[0] and fix_steps[fix] == step:
            x[:] = 0.0
            for k in range(6):
                if not math.isnan(fixes[fix, k]):
                    h[:] = 0.0
                    h[3 + k] = 1.0
                    z = s[k] - fixes[fix, k]
                    innovation = z - x[3 + k]
                    S = joseph(P, x, h, z, variances[k], K, M)
                    if not S > 0.0:
                        return NOT_A_COVARIANCE, step
                    nis[fix] += innovation * innovation / S
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
            return BOW_VERTICAL, step
        if math.pi / 2 - abs(s[3]) < margins[1]:
            return AT_A_POLE, step
        if step % keep == 0:
            for i in range(15):
                if not P[i, i] >= 0.0:
                    return NOT_A_COVARIANCE, step
                states_out[step // keep, i] = angles[i] if i < 3 else s[i - 3]
            P_out[step // keep] = P
        if step == n:
            break
        radius = earth_radius + s[5]
        weight = gravity * (earth_radius / radius) ** 2
        hull_turn(dtheta[step], s[6:9], s[9:12], mount[step], mount[step + 1], axes, dt, rates, hull)
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
        advance(C, hull, dv[step], frame, dt, force, scratch)
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
    return FINISHED, n


@njit(cache=True, nogil=True)
def wander_matrix(C, s, force, pushed, yaw, rates, mount_angle, axes, radius, weight, F):
    """Error model of `fogkit.gyrocompass.filters.wander`: write F, shape (17, 17).

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
    F[:, :] = 0.0
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


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True)
def unit(x, y):
    """Direction of a vector of two; the first axis if it has none."""
    length = math.sqrt(x * x + y * y)
    if length < 1e-12:
        return 1.0, 0.0
    return x / length, y / length


@njit(cache=True, nogil=True)
def wander_fix(P, x, s, fix, variances, h, K, M):
    """Corrections x by one measurement of what is not NaN in `fix`. Return the sum of squares of innovations, or -1."""
    total = 0.0
    for k in range(6):
        if math.isnan(fix[k]):
            continue
        h[:] = 0.0
        h[3 + k] = 1.0
        z = s[k] - fix[k]
        innovation = z - x[3 + k]
        S = joseph(P, x, h, z, variances[k], K, M)
        if not S > 0.0:
            return -1.0
        total += innovation * innovation / S
    return total


@njit(cache=True, nogil=True)
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
    """The filter with the Earth's axis for a state; arguments as those of `extended_run`."""
    n, moving = dtheta.shape[0], 11
    F, M, h, K, x = np.empty((17, 17)), np.empty((17, 17)), np.zeros(17), np.empty(17), np.zeros(17)
    Phi, T, N = np.empty((moving, 17)), np.empty((moving, 17)), np.empty((17, moving))
    total, old = np.eye(17), np.empty((moving, 17))
    rates, hull, frame = np.empty(3), np.empty(3), np.zeros(3)
    force, scratch, before = np.zeros(3), np.empty(3), np.empty((3, 3))
    fix = 0
    for step in range(n + 1):
        if smooth and step % keep == 0 and step > 0:
            Phi_out[step // keep - 1] = total
            before_out[step // keep - 1] = P
            total[:, :] = 0.0
            for i in range(17):
                total[i, i] = 1.0
        while fix < fix_steps.shape[0] and fix_steps[fix] == step:
            x[:] = 0.0
            nis[fix] = wander_fix(P, x, s, fixes[fix], variances, h, K, M)
            if nis[fix] < 0.0:
                return NOT_A_COVARIANCE, step
            for i in range(3):
                scratch[i] = -x[i]
            for i in range(8):
                s[i] -= x[3 + i]
            turn(C, scratch, True)
            for i in range(8, 14):
                s[i] += x[3 + i]
            if smooth:
                for i in range(17):
                    x_out[step // keep, i] += x[i]
            fix += 1
        if math.pi / 2 - abs(s[3]) < margins[1]:
            return AT_A_POLE, step
        if step % keep == 0:
            for i in range(17):
                if not P[i, i] >= 0.0:
                    return NOT_A_COVARIANCE, step
            C_out[step // keep] = C
            states_out[step // keep] = s
            P_out[step // keep] = P
        if step == n:
            break
        radius = earth_radius + s[5]
        weight = gravity * (earth_radius / radius) ** 2
        hull_turn(dtheta[step], s[8:11], s[11:14], mount[step], mount[step + 1], axes, dt, rates, hull)
        north, up, east = s[0], s[1], s[2]
        sl, cl = math.sin(s[3]), math.cos(s[3])
        e0, e2 = s[6] / cl, s[7] / cl
        v0, v2 = north * e0 - east * e2, north * e2 + east * e0
        frame[0], frame[1] = EARTH_RATE * s[6] + v2 / radius, EARTH_RATE * sl
        frame[2] = EARTH_RATE * s[7] - v0 / radius
        for i in range(3):
            rates[i] /= dt
            before[i, :] = C[i, :]
        yaw = 0.0
        if follows and north * north + east * east > UNDER_WAY * UNDER_WAY * (P[3, 3] + P[5, 5]):
            yaw = turn_rate(C, hull, frame, frame[1] + east * sl / cl / radius, dt)
        angle = 0.5 * (mount[step] + mount[step + 1])
        advance(C, hull, dv[step], frame, dt, force, scratch)
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
        propagate(P, F, dt, moving, Phi, T, N)
        for i in range(3):
            for j in range(3):
                for k in range(3):
                    P[i, j] += dt * F[i, 11 + k] * F[j, 11 + k] * gyro_density[k]
            P[3 + i, 3 + i] += dt * force_density
        for i in range(17):
            P[i, i] += dt * walks[i]
        if smooth:
            old[:, :] = total[:moving]
            for i in range(moving):
                for j in range(17):
                    total[i, j] = 0.0
                for k in range(17):
                    f = Phi[i, k]
                    if f != 0.0:
                        for j in range(17):
                            total[i, j] += f * (old[k, j] if k < moving else (1.0 if k == j else 0.0))
        s[0] += dt * (m0 * f0 + m2 * f2 - yaw * east)
        s[1] += dt * rise
        s[2] += dt * (m0 * f2 - m2 * f0 + yaw * north)
        north, east = 0.5 * (north + s[0]), 0.5 * (east + s[2])
        s[3] += north / radius * dt
        s[4] += east / (cl * radius) * dt
        s[5] += 0.5 * (up + s[1]) * dt
        s[6] -= (north * e0 - east * e2) * sl / radius * dt
        s[7] -= (north * e2 + east * e0) * sl / radius * dt
    return FINISHED, n
