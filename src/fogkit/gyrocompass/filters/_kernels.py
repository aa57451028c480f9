"""Compiled steps that both filters take: plain arrays in, plain arrays out, nothing checked.

Arrays are copied element by element: a slice assigned to a slice makes `numba` compile the text of its error message,
seconds of it. Without Python's model of errors a division has no branch for zero; no divisor here is one.
"""

import math

from numba import njit

FINISHED, NOT_A_COVARIANCE, BOW_VERTICAL, AT_A_POLE = 0, 1, 2, 3


@njit(cache=True, nogil=True, error_model="numpy")
def rotation(r, R):
    """Rotation of the vector r, written into R, shape (3, 3)."""
    square = r[0] * r[0] + r[1] * r[1] + r[2] * r[2]
    if square < 1e-4:
        s, c = 1.0 - square / 6.0 * (1.0 - square / 20.0), 0.5 - square / 24.0 * (1.0 - square / 30.0)
    else:
        angle = math.sqrt(square)
        s, c = math.sin(angle) / angle, (1.0 - math.cos(angle)) / square
    x, y, z = r[0], r[1], r[2]
    R[0, 0], R[0, 1], R[0, 2] = 1.0 - c * (y * y + z * z), c * x * y - s * z, c * x * z + s * y
    R[1, 0], R[1, 1], R[1, 2] = c * x * y + s * z, 1.0 - c * (x * x + z * z), c * y * z - s * x
    R[2, 0], R[2, 1], R[2, 2] = c * x * z - s * y, c * y * z + s * x, 1.0 - c * (x * x + y * y)


@njit(cache=True, nogil=True, error_model="numpy")
def turn_left(C, r, R):
    """Multiply C from the left by the rotation of the vector r, in place; R is scratch, shape (3, 3)."""
    rotation(r, R)
    for k in range(3):
        u, v, w = C[0, k], C[1, k], C[2, k]
        for i in range(3):
            C[i, k] = R[i, 0] * u + R[i, 1] * v + R[i, 2] * w


@njit(cache=True, nogil=True, error_model="numpy")
def turn_right(C, r, R):
    """Multiply C from the right by the rotation of the vector r, in place; R is scratch, shape (3, 3)."""
    rotation(r, R)
    for k in range(3):
        u, v, w = C[k, 0], C[k, 1], C[k, 2]
        for i in range(3):
            C[k, i] = u * R[0, i] + v * R[1, i] + w * R[2, i]


@njit(cache=True, nogil=True, error_model="numpy")
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


@njit(cache=True, nogil=True, error_model="numpy")
def advance(C, hull, dv, frame, dt, force, scratch, R):
    """Attitude over a step, in a frame that turns with the rate `frame`.

    `force`, the mean specific force in the frame, is written: at the middle of the turn. `scratch`, shape (3,), and R,
    (3, 3), are scratch.
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
    turn_right(C, hull, R)
    turn_left(C, scratch, R)


@njit(cache=True, nogil=True, error_model="numpy")
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


@njit(cache=True, nogil=True, error_model="numpy")
def measure(P, x, s, fix, variances, h, K, M):
    """Corrections x by one measurement of what is not NaN in `fix`. Return the sum of squares of innovations, or -1."""
    total = 0.0
    for i in range(x.shape[0]):
        x[i] = 0.0
    for k in range(6):
        if math.isnan(fix[k]):
            continue
        for i in range(h.shape[0]):
            h[i] = 0.0
        h[3 + k] = 1.0
        z = s[k] - fix[k]
        innovation = z - x[3 + k]
        S = joseph(P, x, h, z, variances[k], K, M)
        if not S > 0.0:
            return -1.0
        total += innovation * innovation / S
    return total


@njit(cache=True, nogil=True, error_model="numpy")
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


@njit(cache=True, nogil=True, error_model="numpy")
def chain(Phi, total, T):
    """Multiply `total`, shape (n, n), from the left by a transition of which Phi, shape (moving, n), is what moves.

    The other rows of both are those of the unit matrix. T, shape (moving, n), is scratch.
    """
    moving, n = Phi.shape
    for i in range(moving):
        for j in range(n):
            T[i, j], total[i, j] = total[i, j], 0.0
    for i in range(moving):
        for k in range(n):
            f = Phi[i, k]
            if f != 0.0 and k < moving:
                for j in range(n):
                    total[i, j] += f * T[k, j]
            elif f != 0.0:
                total[i, k] += f
