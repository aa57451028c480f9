"""Compiled parts of the gyrocompass: plain arrays in, plain arrays out, nothing checked.

States are in the order of (10) of the thesis: heading, trim, roll; velocity north, up, east; latitude, longitude,
height; biases of the gyros x, y, z; their scale factors.
"""

import math

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
