"""Compiled loops over samples: plain arrays in, plain arrays out, nothing checked."""

from numba import njit


@njit(cache=True, nogil=True)
def angle(rate, mean, out):
    """Running sum of ``rate - mean`` from 0: shape (n,) into (n + 1,), in units of rate times the sampling time."""
    # Kahan's compensation: over millions of samples a plain sum would carry rounding of all that it has passed
    total, lost = 0.0, 0.0
    out[0] = 0.0
    for i in range(rate.size):
        term = (rate[i] - mean) - lost
        raised = total + term
        lost = (raised - total) - term
        total = raised
        out[i + 1] = total


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract", "nsz"})  # lets the sum run in vector registers
def second_difference_power(angle, factor):
    """Mean square of ``angle[k + 2 m] - 2 angle[k + m] + angle[k]`` over all k."""
    count = angle.size - 2 * factor
    # views instead of shifted indices: without index arithmetic the loop is compiled to vector instructions
    first, middle, last = angle[:count], angle[factor : factor + count], angle[2 * factor : 2 * factor + count]
    total = 0.0
    for k in range(count):
        difference = (last[k] - middle[k]) - (middle[k] - first[k])
        total += difference * difference
    return total / count
