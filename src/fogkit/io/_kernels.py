"""Compiled loops over samples: plain arrays in, plain arrays out, nothing checked."""

import numpy as np
from numba import njit

# columns of the state of a channel
LAST, RUN, LONGEST, LONGEST_AT, REPEATS, COUNT, BAD, BAD_AT = range(8)
MAX, MAX_COUNT, NEXT_MAX, NEXT_MAX_COUNT, MAX_RUN = range(8, 13)
MIN, MIN_COUNT, NEXT_MIN, NEXT_MIN_COUNT, MIN_RUN = range(13, 18)
HUGE, HUGE_AT = 18, 19
SCALE, BEFORE, SPIKES, SPIKE_AT, SPIKE_SIZE = range(20, 25)
LAST_GOOD = 25
WIDTH = 26

SETTLING = 64.0  # samples over which the usual change between two samples is taken
SPIKE = 30.0  # times the usual change: there and back again


@njit(cache=True, nogil=True)
def scan(values, first, limits, state):
    """Count what one more block of each channel holds: shape (k, n), limits (k,), state (k, WIDTH), in place.

    A run is a number of equal samples, one after the other. Extremes keep how often they came, how often the next
    smaller or larger reading came, and the longest run at the extreme.
    """
    for c in range(values.shape[0]):
        row = values[c]
        s = state[c]
        limit = limits[c]
        last, run = s[LAST], s[RUN]
        if s[COUNT] == 0:
            s[SCALE] = np.median(np.abs(np.diff(row[:512]))) if row.size > 2 else np.inf
            if not np.isfinite(s[SCALE]):
                s[SCALE] = np.inf
        for i in range(row.size):
            v = row[i]
            if not np.isfinite(v):
                if s[BAD] == 0:
                    s[BAD_AT] = first + i
                s[BAD] += 1
                last, run = np.nan, 0.0
                continue
            if abs(v) > limit:
                if s[HUGE] == 0:
                    s[HUGE_AT] = first + i
                s[HUGE] += 1
            s[COUNT] += 1
            if s[COUNT] > 1:  # NaN before: no change known
                change = v - s[LAST_GOOD]
                scale = s[SCALE]
                if s[COUNT] == 2:
                    s[BEFORE] = -change  # the first sample may be the leap
                if s[BEFORE] * change < 0:
                    size = min(abs(change), abs(s[BEFORE]))
                    if size > SPIKE * scale and abs(change + s[BEFORE]) < 0.5 * size:
                        if s[SPIKES] == 0:
                            s[SPIKE_AT] = first + i - 1
                        s[SPIKES] += 1
                        s[SPIKE_SIZE] = max(s[SPIKE_SIZE], size)
                if scale < np.inf:
                    s[SCALE] += (min(abs(change), 4 * scale + 1e-300) - scale) / SETTLING
                s[BEFORE] = change
            s[LAST_GOOD] = v
            if v == last:
                run += 1
                s[REPEATS] += 1
            else:
                run = 1.0
                last = v
            if run > s[LONGEST]:
                s[LONGEST] = run
                s[LONGEST_AT] = first + i - run + 1
            if v >= s[NEXT_MAX]:
                if v > s[MAX]:
                    s[NEXT_MAX], s[NEXT_MAX_COUNT] = s[MAX], s[MAX_COUNT]
                    s[MAX], s[MAX_COUNT], s[MAX_RUN] = v, 1.0, 1.0
                elif v == s[MAX]:
                    s[MAX_COUNT] += 1
                    s[MAX_RUN] = max(s[MAX_RUN], run)
                elif v > s[NEXT_MAX]:
                    s[NEXT_MAX], s[NEXT_MAX_COUNT] = v, 1.0
                else:
                    s[NEXT_MAX_COUNT] += 1
            if v <= s[NEXT_MIN]:
                if v < s[MIN]:
                    s[NEXT_MIN], s[NEXT_MIN_COUNT] = s[MIN], s[MIN_COUNT]
                    s[MIN], s[MIN_COUNT], s[MIN_RUN] = v, 1.0, 1.0
                elif v == s[MIN]:
                    s[MIN_COUNT] += 1
                    s[MIN_RUN] = max(s[MIN_RUN], run)
                elif v < s[NEXT_MIN]:
                    s[NEXT_MIN], s[NEXT_MIN_COUNT] = v, 1.0
                else:
                    s[NEXT_MIN_COUNT] += 1
        s[LAST], s[RUN] = last, run


@njit(cache=True, nogil=True)
def repeated_rows(values, last):
    """Samples of a block, shape (k, n), in which every channel repeats the one before; `last`, shape (k,), in place."""
    count = 0
    for i in range(values.shape[1]):
        same = True
        for c in range(values.shape[0]):
            if values[c, i] != last[c]:
                same = False
                break
        if same:
            count += 1
        else:
            for c in range(values.shape[0]):
                last[c] = values[c, i]
    return count
