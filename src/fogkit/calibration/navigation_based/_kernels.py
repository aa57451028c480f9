"""Compiled loops over the steps of many recordings: plain arrays in, plain arrays out, nothing checked."""

import math

from numba import njit


@njit(cache=True, nogil=True)
def compensate(
    raw_gyro,  # raw increments, shape (tests, n, 3)
    raw_accel,
    dt,  # s
    gyro_matrix,  # shape (3, 3)
    gyro_bias,  # rad/s, shape (3,)
    accel_matrix,
    accel_bias,  # m/s^2
    out_gyro,  # rad, shape (tests, n, 3)
    out_accel,  # m/s
):
    """Eqs. (1) and (2): bias and matrix of both triads in one pass."""
    for raw, matrix, bias, out in (
        (raw_gyro, gyro_matrix, gyro_bias, out_gyro),
        (raw_accel, accel_matrix, accel_bias, out_accel),
    ):
        m00, m01, m02 = matrix[0, 0], matrix[0, 1], matrix[0, 2]
        m10, m11, m12 = matrix[1, 0], matrix[1, 1], matrix[1, 2]
        m20, m21, m22 = matrix[2, 0], matrix[2, 1], matrix[2, 2]
        b0, b1, b2 = bias[0] * dt, bias[1] * dt, bias[2] * dt
        for test in range(raw.shape[0]):
            for p in range(raw.shape[1]):
                x, y, z = raw[test, p, 0], raw[test, p, 1], raw[test, p, 2]
                out[test, p, 0] = b0 + m00 * x + m01 * y + m02 * z
                out[test, p, 1] = b1 + m10 * x + m11 * y + m12 * z
                out[test, p, 2] = b2 + m20 * x + m21 * y + m22 * z


@njit(cache=True, nogil=True)
def project(
    quaternion,  # attitude at the nodes, scalar last, shape (tests, n + 1, 4)
    dtheta,  # compensated increments, rad, shape (tests, n, 3)
    first,  # first step of the sum
    last,  # step after the last
    out,  # element i, k, j: sum of C_ik dtheta_j, rad, shape (tests, 3, 3, 3)
):
    """Sums (12), with the attitude in the middle of each step: at its ends the error would be of first order."""
    out[:] = 0.0
    for test in range(dtheta.shape[0]):
        total = out[test]
        for p in range(first, last):
            # the kernel of the navigation keeps the sign of the quaternion, so the mean is the middle of the arc
            x = quaternion[test, p, 0] + quaternion[test, p + 1, 0]
            y = quaternion[test, p, 1] + quaternion[test, p + 1, 1]
            z = quaternion[test, p, 2] + quaternion[test, p + 1, 2]
            w = quaternion[test, p, 3] + quaternion[test, p + 1, 3]
            scale = 1.0 / math.sqrt(x * x + y * y + z * z + w * w)
            x, y, z, w = scale * x, scale * y, scale * z, scale * w
            x2, y2, z2 = x + x, y + y, z + z
            xx, yy, zz, xy, xz, yz, wx, wy, wz = x * x2, y * y2, z * z2, x * y2, x * z2, y * z2, w * x2, w * y2, w * z2
            C = (1.0 - yy - zz, xy - wz, xz + wy, xy + wz, 1.0 - xx - zz, yz - wx, xz - wy, yz + wx, 1.0 - xx - yy)
            a = (dtheta[test, p, 0], dtheta[test, p, 1], dtheta[test, p, 2])
            for i in range(3):
                for k in range(3):
                    for j in range(3):
                        total[i, k, j] += C[3 * i + k] * a[j]
