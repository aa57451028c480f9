"""Compiled motion of a unit on a rough turntable, and its increments: plain arrays in, plain arrays out, not checked.

Vectors are three scalars here: a small array per node would cost more than the arithmetic. The model of a motion is the
tuple `fogkit.stand.turn_motion.TurnMotion.model`, in the order of the arguments of `evaluate`; the equations are
derived in the notes of that class, and their numbers in square brackets are those of the notes.
"""

import math

from numba import njit

# Powers of the squared angle in sin(p)/p, (1-cos(p))/p^2, (p-sin(p))/p^3 and in the derivatives of the last two by the
# squared angle. The rotations are below 0.5 rad, where what is left out is below 1e-17; closed forms would cancel.
FIRST = (1.0, -1.0 / 6, 1.0 / 120, -1.0 / 5040, 1.0 / 362880, -1.0 / 39916800, 1.0 / 6227020800)
SECOND = (1.0 / 2, -1.0 / 24, 1.0 / 720, -1.0 / 40320, 1.0 / 3628800, -1.0 / 479001600)
THIRD = (1.0 / 6, -1.0 / 120, 1.0 / 5040, -1.0 / 362880, 1.0 / 39916800, -1.0 / 6227020800)
SECOND_SLOPE = (-1.0 / 24, 2.0 / 720, -3.0 / 40320, 4.0 / 3628800, -5.0 / 479001600)
SILENT = 50.0  # decay, as a natural logarithm, after which nothing is left of what rings: 2e-22
THIRD_SLOPE = (-1.0 / 120, 2.0 / 5040, -3.0 / 362880, 4.0 / 39916800, -5.0 / 6227020800)


@njit(cache=True, nogil=True, inline="always")
def _cross(ax, ay, az, bx, by, bz):
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@njit(cache=True, nogil=True, inline="always")
def _polynomial(c, x):
    value = c[-1]
    for j in range(len(c) - 2, -1, -1):
        value = value * x + c[j]
    return value


@njit(cache=True, nogil=True, inline="always")
def _times(M, x, y, z):
    return (
        M[0, 0] * x + M[0, 1] * y + M[0, 2] * z,
        M[1, 0] * x + M[1, 1] * y + M[1, 2] * z,
        M[2, 0] * x + M[2, 1] * y + M[2, 2] * z,
    )


@njit(cache=True, nogil=True, inline="always")
def _small_turn(wx, wy, wz, sign, x, y, z):
    """Vector turned by a small rotation vector, or back with `sign` -1."""
    square = wx * wx + wy * wy + wz * wz
    first, second = sign * _polynomial(FIRST, square), _polynomial(SECOND, square)
    ax, ay, az = _cross(wx, wy, wz, x, y, z)
    bx, by, bz = _cross(wx, wy, wz, ax, ay, az)
    return x + first * ax + second * bx, y + first * ay + second * by, z + first * az + second * bz


@njit(cache=True, nogil=True, inline="always")
def _small_rate(wx, wy, wz, dx, dy, dz):
    """[3]: angular rate, in turned axes, of a small rotation vector w with the derivative d."""
    square = wx * wx + wy * wy + wz * wz
    second, third = _polynomial(SECOND, square), _polynomial(THIRD, square)
    ax, ay, az = _cross(wx, wy, wz, dx, dy, dz)
    bx, by, bz = _cross(wx, wy, wz, ax, ay, az)
    return dx - second * ax + third * bx, dy - second * ay + third * by, dz - second * az + third * bz


@njit(cache=True, nogil=True, inline="always")
def _small_acceleration(wx, wy, wz, dx, dy, dz, ex, ey, ez):
    """Derivative of `_small_rate` with the second derivative e of the rotation vector."""
    square, growth = wx * wx + wy * wy + wz * wz, 2.0 * (wx * dx + wy * dy + wz * dz)
    second_rate, third_rate = growth * _polynomial(SECOND_SLOPE, square), growth * _polynomial(THIRD_SLOPE, square)
    third = _polynomial(THIRD, square)
    x, y, z = _small_rate(wx, wy, wz, ex, ey, ez)
    ax, ay, az = _cross(wx, wy, wz, dx, dy, dz)
    bx, by, bz = _cross(wx, wy, wz, ax, ay, az)
    cx, cy, cz = _cross(dx, dy, dz, ax, ay, az)
    return (
        x - second_rate * ax + third_rate * bx + third * cx,
        y - second_rate * ay + third_rate * by + third * cy,
        z - second_rate * az + third_rate * bz + third * cz,
    )


@njit(cache=True, nogil=True, inline="always")
def _about(ux, uy, uz, s, c, x, y, z):
    """Vector turned about a unit axis by the angle of sine s and cosine c."""
    ax, ay, az = _cross(ux, uy, uz, x, y, z)
    along = (1.0 - c) * (ux * x + uy * y + uz * z)
    return c * x + s * ax + along * ux, c * y + s * ay + along * uy, c * z + s * az + along * uz


@njit(cache=True, nogil=True)
def _coordinates(t, wobble, starts, angles, lags, decay, frequency):
    """Angle of the turn with two derivatives, wobble with two derivatives, lag of the absorber with its derivative."""
    piece = 0
    while piece < starts.shape[0] and t >= starts[piece]:
        piece += 1
    tau = t - starts[max(piece - 1, 0)]
    phi, rate, acceleration = angles[piece, 6], 0.0, 0.0
    for j in range(5, -1, -1):
        acceleration = acceleration * tau + 2.0 * rate
        rate = rate * tau + phi
        phi = phi * tau + angles[piece, j]

    wx, wy, wz, dx, dy, dz, ex, ey, ez = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    orders = wobble.shape[1]
    s, c = math.sin(phi), math.cos(phi)
    if orders:
        sk, ck = 0.0, 1.0
        for k in range(orders):  # order 0 first
            a, b, n = wobble[0, k], wobble[1, k], float(k)
            px, py, pz = ck * a[0] + sk * b[0], ck * a[1] + sk * b[1], ck * a[2] + sk * b[2]
            qx, qy, qz = ck * b[0] - sk * a[0], ck * b[1] - sk * a[1], ck * b[2] - sk * a[2]
            wx, wy, wz = wx + px, wy + py, wz + pz
            dx, dy, dz = dx + n * qx, dy + n * qy, dz + n * qz
            ex, ey, ez = ex - n * n * px, ey - n * n * py, ez - n * n * pz
            sk, ck = sk * c + ck * s, ck * c - sk * s
        square = rate * rate
        ex, ey, ez = ex * square + dx * acceleration, ey * square + dy * acceleration, ez * square + dz * acceleration
        dx, dy, dz = dx * rate, dy * rate, dz * rate

    lag, lag_rate = 0.0, 0.0
    if frequency > 0.0 and piece > 0:
        for j in range(6, -1, -1):
            lag_rate = lag_rate * tau + lag
            lag = lag * tau + lags[piece, j]
        if decay * tau < SILENT:
            a, b = lags[piece, 7], lags[piece, 8]
            fade = math.exp(-decay * tau)
            sine, cosine = fade * math.sin(frequency * tau), fade * math.cos(frequency * tau)
            lag += a * cosine + b * sine
            lag_rate += (b * frequency - decay * a) * cosine - (a * frequency + decay * b) * sine
    return phi, rate, acceleration, s, c, wx, wy, wz, dx, dy, dz, ex, ey, ez, lag, lag_rate


@njit(cache=True, nogil=True)
def _motion(t, C_0, axis, lever, wobble, starts, angles, lags, decay, frequency, sag, lag_axis, earth, gravity):
    """Rate and specific force, body axes; velocity of the reference point in the case; what turns the body."""
    coordinates = _coordinates(t, wobble, starts, angles, lags, decay, frequency)
    _, rate, acceleration, s, c, wx, wy, wz, dx, dy, dz, ex, ey, ez, lag, lag_rate = coordinates
    ux, uy, uz = axis[0], axis[1], axis[2]
    lx, ly, lz = lever[0], lever[1], lever[2]

    # up and the Earth's rotation in case axes
    vx, vy, vz = C_0[2, 0], C_0[2, 1], C_0[2, 2]
    ox = C_0[0, 0] * earth[0] + C_0[1, 0] * earth[1] + C_0[2, 0] * earth[2]
    oy = C_0[0, 1] * earth[0] + C_0[1, 1] * earth[1] + C_0[2, 1] * earth[2]
    oz = C_0[0, 2] * earth[0] + C_0[1, 2] * earth[1] + C_0[2, 2] * earth[2]

    # [2]: rate and angular acceleration of the case
    rx, ry, rz, ax, ay, az = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    if wobble.shape[1]:
        vx, vy, vz = _small_turn(wx, wy, wz, -1.0, vx, vy, vz)
        ox, oy, oz = _small_turn(wx, wy, wz, -1.0, ox, oy, oz)
        rx, ry, rz = _small_rate(wx, wy, wz, dx, dy, dz)
        ax, ay, az = _small_acceleration(wx, wy, wz, dx, dy, dz, ex, ey, ez)
        rx, ry, rz = _about(ux, uy, uz, -s, c, rx, ry, rz)
        ax, ay, az = _about(ux, uy, uz, -s, c, ax, ay, az)
        kx, ky, kz = _cross(ux, uy, uz, rx, ry, rz)
        ax, ay, az = ax - rate * kx, ay - rate * ky, az - rate * kz
    vx, vy, vz = _about(ux, uy, uz, -s, c, vx, vy, vz)
    ox, oy, oz = _about(ux, uy, uz, -s, c, ox, oy, oz)
    rx, ry, rz = rx + rate * ux, ry + rate * uy, rz + rate * uz
    ax, ay, az = ax + acceleration * ux, ay + acceleration * uy, az + acceleration * uz

    # [4]: specific force at the reference point
    mx, my, mz = _cross(rx, ry, rz, lx, ly, lz)
    hx, hy, hz = _cross(ax, ay, az, lx, ly, lz)
    kx, ky, kz = _cross(rx + 2.0 * ox, ry + 2.0 * oy, rz + 2.0 * oz, mx, my, mz)
    fx, fy, fz = hx + kx + gravity * vx, hy + ky + gravity * vy, hz + kz + gravity * vz

    # [5]: the body against the case
    sx, sy, sz = 0.0, 0.0, 0.0
    wx, wy, wz = rx + ox, ry + oy, rz + oz
    if frequency > 0.0:
        sx, sy, sz = _times(sag, vx, vy, vz)
        kx, ky, kz = _cross(vx, vy, vz, rx, ry, rz)
        dx, dy, dz = _times(sag, kx, ky, kz)
        sx, sy, sz = sx + lag * lag_axis[0], sy + lag * lag_axis[1], sz + lag * lag_axis[2]
        dx, dy, dz = dx + lag_rate * lag_axis[0], dy + lag_rate * lag_axis[1], dz + lag_rate * lag_axis[2]
        dx, dy, dz = _small_rate(sx, sy, sz, dx, dy, dz)
        fx, fy, fz = _small_turn(sx, sy, sz, -1.0, fx, fy, fz)
        wx, wy, wz = _small_turn(sx, sy, sz, -1.0, wx, wy, wz)
        wx, wy, wz = wx + dx, wy + dy, wz + dz
    return wx, wy, wz, fx, fy, fz, mx, my, mz, sx, sy, sz


@njit(cache=True, nogil=True)
def evaluate(
    C_0,  # attitude of the case before wobble and turn, shape (3, 3)
    axis,  # of the turn, case axes, unit vector
    lever,  # reference point against a point of the axis, case axes, m
    wobble,  # cosine and sine amplitudes of orders 0 to k of the turn angle, case axes before the turn, (2, k+1, 3)
    starts,  # of the pieces after the first, s, ascending, shape (p,)
    angles,  # polynomials of the turn angle in the time since the start of the piece, shape (p+1, 7)
    lags,  # the same of the lag, then amplitudes of cosine and sine that decay, shape (p+1, 9)
    decay,  # 1/s
    frequency,  # damped, rad/s; 0 without absorber
    sag,  # rotation vector by the direction of up in the case, rad, shape (3, 3)
    lag_axis,  # rotation vector by the lag, shape (3,)
    earth,  # rotation of the Earth, east, north, up, rad/s
    gravity,  # m/s^2
    times,  # s, shape (n,)
    C_b_n,  # outputs: attitude, shape (n, 3, 3)
    vectors,  # rate, specific force, both body axes, position, velocity, both east, north, up, shape (n, 4, 3)
    scalars,  # angle of the turn and lag, shape (n, 2)
):
    """Motion at any times."""
    rest = (C_0, axis, lever, wobble, starts, angles, lags, decay, frequency, sag, lag_axis, earth, gravity)
    for i in range(times.shape[0]):
        coordinates = _coordinates(times[i], wobble, starts, angles, lags, decay, frequency)
        phi, _, _, s, c, wx, wy, wz, _, _, _, _, _, _, lag, _ = coordinates
        wbx, wby, wbz, fx, fy, fz, mx, my, mz, sx, sy, sz = _motion(times[i], *rest)
        scalars[i, 0], scalars[i, 1] = phi, lag
        vectors[i, 0, 0], vectors[i, 0, 1], vectors[i, 0, 2] = wbx, wby, wbz
        vectors[i, 1, 0], vectors[i, 1, 1], vectors[i, 1, 2] = fx, fy, fz
        for j in range(5):  # [1]: three body axes, then position and velocity, which the absorber does not turn
            if j < 3:
                x, y, z = (1.0 if j == 0 else 0.0), (1.0 if j == 1 else 0.0), (1.0 if j == 2 else 0.0)
                x, y, z = _small_turn(sx, sy, sz, 1.0, x, y, z)
            elif j == 3:
                x, y, z = lever[0], lever[1], lever[2]
            else:
                x, y, z = mx, my, mz
            x, y, z = _about(axis[0], axis[1], axis[2], s, c, x, y, z)
            x, y, z = _small_turn(wx, wy, wz, 1.0, x, y, z)
            x, y, z = _times(C_0, x, y, z)
            if j < 3:
                C_b_n[i, 0, j], C_b_n[i, 1, j], C_b_n[i, 2, j] = x, y, z
            else:
                vectors[i, j - 1, 0], vectors[i, j - 1, 1], vectors[i, j - 1, 2] = x, y, z


@njit(cache=True, nogil=True, inline="always")
def _add(row, weight, state, products):
    """Add what a node gives to the sums of a step."""
    for j in range(6):
        row[j] += weight * state[j]
    if products:
        x, y, z = state[0], state[1], state[2]
        row[6] += weight * x * x
        row[7] += weight * y * y
        row[8] += weight * z * z
        row[9] += weight * x * y
        row[10] += weight * x * z
        row[11] += weight * y * z


@njit(cache=True, nogil=True)
def increments(
    C_0,  # as `evaluate`
    axis,
    lever,
    wobble,
    starts,
    angles,
    lags,
    decay,
    frequency,
    sag,
    lag_axis,
    earth,
    gravity,
    still,  # time from which the unit rests, s
    first,  # beginning of the first step, s
    dt,  # duration of a step, s
    nodes,  # of a quadrature on [0, 1], shape (q,)
    weights,
    longest,  # interval on which the quadrature is used, s
    sums,  # output, zeros, shape (n, 6), or (n, 15) with products of rates and changes of the rate
):
    """Sums over steps of rate and specific force; of products of rates, and change of the rate, if there is room."""
    model = (C_0, axis, lever, wobble, starts, angles, lags, decay, frequency, sag, lag_axis, earth, gravity)
    products = sums.shape[1] > 6
    before, after = _motion(starts[0] - 1.0, *model), _motion(still, *model)
    here, known = before, -1
    for k in range(sums.shape[0]):
        start, stop = first + k * dt, first + (k + 1) * dt
        row = sums[k]
        if stop <= starts[0]:
            _add(row, dt, before, products)
            continue
        if start >= still:
            _add(row, dt, after, products)
            continue
        left, cut = start, 0
        while left < stop:
            while cut < starts.shape[0] and starts[cut] <= left:
                cut += 1
            right = min(stop, starts[cut]) if cut < starts.shape[0] else stop
            parts = math.ceil((right - left) / longest)
            width = (right - left) / parts
            for part in range(parts):
                for q in range(nodes.shape[0]):
                    state = _motion(left + (part + nodes[q]) * width, *model)
                    _add(row, weights[q] * width, state, products)
            left = right
        if products:
            if k != known:  # the end of the step before is the beginning of this one
                here = _motion(start, *model)
            there = _motion(stop, *model)
            for j in range(3):
                row[12 + j] = there[j] - here[j]
            here, known = there, k + 1
