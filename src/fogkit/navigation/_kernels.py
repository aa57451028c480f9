"""Compiled loop of the strapdown mechanisation: plain arrays in, plain arrays out, nothing checked.

Components of vectors are scalars here: a small array per step would cost more than the arithmetic. Attitudes are unit
quaternions ``(x, y, z, w)``, scalar last as in SciPy, that take body components to east-north-up. The equations are
derived in `fogkit.navigation.strapdown`; their numbers in square brackets are those of its notes.
"""

import math

from numba import njit

from fogkit.constants import (
    EARTH_RATE,
    ECCENTRICITY_SQUARED,
    EQUATORIAL_GRAVITY,
    FLATTENING,
    GRAVITY_RATIO,
    SEMI_MAJOR_AXIS,
    SOMIGLIANA,
)

NONE, PREVIOUS, CENTRAL = 0, 1, 2
# Reciprocals: without fastmath a division stays a division, five times as slow as the product.
R3, R6, R12, R24, R48 = 1.0 / 3, 1.0 / 6, 1.0 / 12, 1.0 / 24, 1.0 / 48
COSINE = (1.0, -1.0 / 8, 1.0 / 384, -1.0 / 46080, 1.0 / 10321920, -1.0 / 3715891200)  # of half the angle
SINE = (1.0 / 2, -1.0 / 48, 1.0 / 3840, -1.0 / 645120, 1.0 / 185794560)  # of half the angle, by the angle
THIRD = (1.0 / 6, -1.0 / 120, 1.0 / 5040, -1.0 / 362880, 1.0 / 39916800, -1.0 / 6227020800)
# Change of latitude, rad, up to which sine and cosine follow from those of an anchor; 1e-17 is left out.
ANCHOR_LIMIT = 1e-3
SERIES_LIMIT = 1.0 / 16.0  # square of the angle below which the series are used, rad^2


@njit(cache=True, nogil=True, inline="always")
def _cross(ax, ay, az, bx, by, bz):
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@njit(cache=True, nogil=True, inline="always")
def _rotate(C, x, y, z):
    """Product of a matrix, as a tuple of nine entries row by row, and a vector."""
    return C[0] * x + C[1] * y + C[2] * z, C[3] * x + C[4] * y + C[5] * z, C[6] * x + C[7] * y + C[8] * z


@njit(cache=True, nogil=True, inline="always")
def _matrix(x, y, z, w):
    """Rotation matrix of a unit quaternion, as nine entries row by row."""
    x2, y2, z2 = x + x, y + y, z + z
    xx, yy, zz, xy, xz, yz, wx, wy, wz = x * x2, y * y2, z * z2, x * y2, x * z2, y * z2, w * x2, w * y2, w * z2
    return 1.0 - yy - zz, xy - wz, xz + wy, xy + wz, 1.0 - xx - zz, yz - wx, xz - wy, yz + wx, 1.0 - xx - yy


@njit(cache=True, nogil=True, inline="always")
def _product(ax, ay, az, aw, bx, by, bz, bw):
    """Quaternion of the rotation b followed by a."""
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


@njit(cache=True, nogil=True, inline="always")
def _polynomial(c, x):
    value = c[-1]
    for j in range(len(c) - 2, -1, -1):
        value = value * x + c[j]
    return value


@njit(cache=True, nogil=True, inline="always")
def _coefficients(x):
    """``cos(p/2), sin(p/2)/p, (1-cos(p))/p^2, (p-sin(p))/p^3`` for the angle p whose square is `x`.

    The closed forms lose digits at small angles: the last one all of them at 1e-5 rad. The first terms left out of the
    series are below 1e-17 at `SERIES_LIMIT`.
    """
    if x < SERIES_LIMIT:
        cosine, sine, third = _polynomial(COSINE, x), _polynomial(SINE, x), _polynomial(THIRD, x)
    else:
        p = math.sqrt(x)
        cosine = math.cos(0.5 * p)
        sine = math.sin(0.5 * p) / p
        third = (1.0 - 2.0 * sine * cosine) / x
    return cosine, sine, 2.0 * sine * sine, third


@njit(cache=True, nogil=True, inline="always")
def _earth(sine, cosine, alt, normal):
    """Reciprocals of the radii to the position, along and across the meridian, and of the cosine; normal gravity."""
    sine2 = sine * sine
    w = 1.0 / math.sqrt(1.0 - ECCENTRICITY_SQUARED * sine2)
    across = SEMI_MAJOR_AXIS * w
    along = (SEMI_MAJOR_AXIS * (1.0 - ECCENTRICITY_SQUARED)) * w * w * w
    gravity = 0.0
    if normal:
        h = alt * (1.0 / SEMI_MAJOR_AXIS)
        gravity = EQUATORIAL_GRAVITY * (1.0 + SOMIGLIANA * sine2) * w
        gravity *= 1.0 - 2.0 * (1.0 + FLATTENING + GRAVITY_RATIO - 2.0 * FLATTENING * sine2) * h + 3.0 * h * h
    return 1.0 / (along + alt), 1.0 / (across + alt), 1.0 / cosine, gravity


@njit(cache=True, nogil=True)
def navigate(
    dtheta,  # integrals of the rate of the body, rad, shape (n, 3)
    dv,  # integrals of the specific force, m/s, shape (n, 3)
    dt,  # duration of a step, s
    scheme,  # NONE, PREVIOUS or CENTRAL: neighbours from which coning and sculling are computed
    normal,  # whether normal gravity is added to `gravity`
    gravity,  # gravity of each step, east, north, up, m/s^2, shape (n, 3), or (1, 3) for all
    fixed,  # whether the position is held
    lowest_cosine,  # cosine of the largest latitude, either side
    highest,  # largest height, up or down, m
    resets,  # how many steps are done when the velocity is set to zero, ascending
    every,  # steps from one row of the output to the next
    attitude,  # quaternion at the start, shape (4,)
    velocity,  # velocity at the start, m/s, shape (3,)
    position,  # latitude, longitude, height at the start, rad and m, shape (3,)
    out_attitude,  # shape (rows, 4), or empty; rows start with the state at the start
    out_velocity,  # shape (rows, 3)
    out_position,  # shape (rows, 3), or empty
):
    """Navigate one recording; return the step at which the position left its limits, or -1."""
    steps = dtheta.shape[0]
    qx, qy, qz, qw = attitude
    ve, vn, vu = velocity
    lat_0, lon_0, alt_0 = position
    lat, lon, alt = 0.0, 0.0, 0.0  # moved so far: what slow motion adds in a step is lost in the rounding of the whole
    with_attitude, with_position = out_attitude.shape[0] > 0, out_position.shape[0] > 0
    next_reset = 0
    anchor, anchor_sine, anchor_cosine = 0.0, math.sin(lat_0), math.cos(lat_0)
    sine, cosine = anchor_sine, anchor_cosine
    inv_along, inv_across, secant, normal_gravity = _earth(sine, cosine, alt_0, normal)
    ge, gn, gu = gravity[0, 0], gravity[0, 1], gravity[0, 2]
    # acceleration by gravity and Coriolis in the previous step; only the mean position of the step is predicted by it
    he, hn, hu = ge, gn, gu - normal_gravity

    row, due = 0, 0
    for k in range(steps + 1):
        while next_reset < resets.shape[0] and resets[next_reset] == k:
            ve, vn, vu = 0.0, 0.0, 0.0
            next_reset += 1
        if k == due:
            if with_attitude:
                out_attitude[row, 0], out_attitude[row, 1], out_attitude[row, 2], out_attitude[row, 3] = qx, qy, qz, qw
            out_velocity[row, 0], out_velocity[row, 1], out_velocity[row, 2] = ve, vn, vu
            if with_position:
                out_position[row, 0], out_position[row, 1], out_position[row, 2] = lat_0 + lat, lon_0 + lon, alt_0 + alt
            row += 1
            due += every
        if k == steps:
            break

        ax, ay, az = dtheta[k, 0], dtheta[k, 1], dtheta[k, 2]
        fx, fy, fz = dv[k, 0], dv[k, 1], dv[k, 2]

        # change of the increments from the step before to the step after
        before, after, factor = k, k, 0.0
        if scheme == CENTRAL and steps > 1:
            before, after = max(k - 1, 0), min(k + 1, steps - 1)
            factor = 1.0 if after - before == 2 else 2.0
        elif scheme == PREVIOUS and k > 0:
            before, factor = k - 1, 2.0
        dax = factor * (dtheta[after, 0] - dtheta[before, 0])
        day = factor * (dtheta[after, 1] - dtheta[before, 1])
        daz = factor * (dtheta[after, 2] - dtheta[before, 2])
        dfx = factor * (dv[after, 0] - dv[before, 0])
        dfy = factor * (dv[after, 1] - dv[before, 1])
        dfz = factor * (dv[after, 2] - dv[before, 2])

        # [1], [2]: coning and sculling
        cx, cy, cz = _cross(ax, ay, az, dax, day, daz)
        px, py, pz = ax + cx * R24, ay + cy * R24, az + cz * R24
        sx, sy, sz = _cross(ax, ay, az, dfx, dfy, dfz)
        tx, ty, tz = _cross(fx, fy, fz, dax, day, daz)
        ux, uy, uz = fx + (sx + tx) * R24, fy + (sy + ty) * R24, fz + (sz + tz) * R24

        # [3]: velocity gained, in body axes of the start of the step
        half_cosine, half_sine, second, third = _coefficients(px * px + py * py + pz * pz)
        cx, cy, cz = _cross(px, py, pz, ux, uy, uz)
        sx, sy, sz = _cross(px, py, pz, cx, cy, cz)
        wx, wy, wz = ux + second * cx + third * sx, uy + second * cy + third * sy, uz + second * cz + third * sz

        # [4]: its mean over the step
        cx, cy, cz = _cross(ax, ay, az, fx, fy, fz)
        yx, yy, yz = cx + 0.5 * dfx, cy + 0.5 * dfy, cz + 0.5 * dfz
        cx, cy, cz = _cross(ax, ay, az, yx, yy, yz)
        mx = 0.5 * wx - (yx + 0.5 * cx) * R12
        my = 0.5 * wy - (yy + 0.5 * cy) * R12
        mz = 0.5 * wz - (yz + 0.5 * cz) * R12

        # both in axes of the navigation frame at the start of the step
        C = _matrix(qx, qy, qz, qw)
        we, wn, wu = _rotate(C, wx, wy, wz)
        me, mn, mu = _rotate(C, mx, my, mz)

        # [5]: mean position, and what depends on it
        if not fixed:
            mean_lat = lat + dt * inv_along * (0.5 * (vn + mn + 0.5 * dt * hn) - (wn + dt * hn) * R12)
            mean_alt = alt_0 + alt + dt * (0.5 * (vu + mu + 0.5 * dt * hu) - (wu + dt * hu) * R12)
            change = mean_lat - anchor
            if not abs(change) < ANCHOR_LIMIT:
                anchor, change = mean_lat, 0.0
                anchor_sine, anchor_cosine = math.sin(lat_0 + mean_lat), math.cos(lat_0 + mean_lat)
            x = change * change
            sine_change, cosine_change = change * (1.0 - R6 * x), 1.0 - x * (0.5 - R24 * x)
            sine = anchor_sine * cosine_change + anchor_cosine * sine_change
            cosine = anchor_cosine * cosine_change - anchor_sine * sine_change
            if not (cosine >= lowest_cosine and abs(mean_alt) <= highest):
                return k
            inv_along, inv_across, secant, normal_gravity = _earth(sine, cosine, mean_alt, normal)
        if gravity.shape[0] > 1:
            ge, gn, gu = gravity[k, 0], gravity[k, 1], gravity[k, 2]
        down = gu - normal_gravity
        tangent = sine * secant
        on, ou = EARTH_RATE * cosine, EARTH_RATE * sine

        # [6]: turn of the navigation frame, and gravity and Coriolis, with the velocity at the start of the step
        re, rn = -vn * inv_along, ve * inv_across
        ru = rn * tangent
        te, tn, tu = _cross(dt * re, dt * (rn + on), dt * (ru + ou), we, wn, wu)
        ce, cn, cu = _cross(re, rn + 2.0 * on, ru + 2.0 * ou, ve, vn, vu)
        h0e, h0n, h0u = ge - ce, gn - cn, down - cu

        # [7]: the same with the mean velocity that follows
        me, mn, mu = me - te * R6, mn - tn * R6, mu - tu * R6
        be, bn, bu = ve + me + 0.5 * dt * h0e, vn + mn + 0.5 * dt * h0n, vu + mu + 0.5 * dt * h0u
        re, rn = -bn * inv_along, be * inv_across
        ru = rn * tangent
        ze, zn, zu = dt * re, dt * (rn + on), dt * (ru + ou)
        ce, cn, cu = _cross(re, rn + 2.0 * on, ru + 2.0 * ou, be, bn, bu)
        he, hn, hu = ge - ce, gn - cn, down - cu

        # [8]: the mean velocity anew, and the velocity
        be = ve + me + dt * R6 * (h0e + 2.0 * he)
        bn = vn + mn + dt * R6 * (h0n + 2.0 * hn)
        bu = vu + mu + dt * R6 * (h0u + 2.0 * hu)
        ce, cn, cu = _cross(ze, zn, zu, we - me - te * R3, wn - mn - tn * R3, wu - mu - tu * R3)
        ve += we - ce + dt * he
        vn += wn - cn + dt * hn
        vu += wu - cu + dt * hu
        if not fixed:
            lat += dt * bn * inv_along
            lon += dt * be * inv_across * secant
            alt += dt * bu

        # [9]: attitude; the first term left out of the half-angle series of the navigation frame is its angle^4 / 384
        qx, qy, qz, qw = _product(qx, qy, qz, qw, half_sine * px, half_sine * py, half_sine * pz, half_cosine)
        z2 = ze * ze + zn * zn + zu * zu
        half_sine = z2 * R48 - 0.5
        qx, qy, qz, qw = _product(half_sine * ze, half_sine * zn, half_sine * zu, 1.0 - 0.125 * z2, qx, qy, qz, qw)
        scale = 1.5 - 0.5 * (qx * qx + qy * qy + qz * qz + qw * qw)  # 1 / norm, to first order in its departure
        qx, qy, qz, qw = scale * qx, scale * qy, scale * qz, scale * qw
    return -1


@njit(cache=True, nogil=True)
def navigate_runs(
    dtheta,  # as for `navigate`, with the runs before all other axes, shape (runs, n, 3)
    dv,
    dt,
    scheme,
    normal,
    gravity,  # shape (runs or 1, n or 1, 3)
    fixed,
    lowest_cosine,
    highest,
    resets,  # shape (runs or 1, any)
    every,
    attitude,
    velocity,
    position,
    out_attitude,
    out_velocity,
    out_position,
    out_left,  # what `navigate` returns, shape (runs,)
):
    """Navigate many recordings, one after the other."""
    for i in range(dtheta.shape[0]):
        out_left[i] = navigate(
            dtheta[i],
            dv[i],
            dt,
            scheme,
            normal,
            gravity[i if gravity.shape[0] > 1 else 0],
            fixed,
            lowest_cosine,
            highest,
            resets[i if resets.shape[0] > 1 else 0],
            every,
            attitude[i],
            velocity[i],
            position[i],
            out_attitude[i],
            out_velocity[i],
            out_position[i],
        )
