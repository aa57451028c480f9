"""Means over windows of equal length, from one block of samples after the other, begun anew after each gap."""

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from fogkit.io.recordings import Block

Array = NDArray[np.float64]

GAP = 1.5
"""Step of the time, in sampling times, from which samples are missing between two."""


@dataclass(frozen=True, eq=False)
class Windows:
    """Means of a recording over windows one after the other.

    Attributes
    ----------
    time : ndarray, shape (m,)
        Beginning of each window, s.
    first : ndarray of int, shape (m,)
        Number of its first sample.
    means : ndarray, shape (m, k)
        Mean of each channel.
    size : int
        Samples in a window.
    dt : float
        Sampling time, s.
    left_out : int
        Samples in no window: those before a gap, and at the end, that fill none.
    """

    time: Array
    first: NDArray[np.int64]
    means: Array
    size: int
    dt: float
    left_out: int

    @property
    def duration(self) -> float:
        """Duration of a window, s."""
        return self.size * self.dt


@dataclass(eq=False)
class WindowMeans:
    """Collects `Windows` from blocks.

    Parameters
    ----------
    size : int
        Samples in a window.
    dt : float
        Sampling time, s.
    """

    size: int
    dt: float
    left_out: int = 0
    gaps: int = 0
    _time: list[Array] = field(default_factory=list)
    _first: list[NDArray] = field(default_factory=list)
    _means: list[Array] = field(default_factory=list)
    _rest: tuple[Array, Array, int] | None = None

    def update(self, block: Block) -> None:
        """Take one more block."""
        time, values, first = block.time, block.values, block.first
        if self._rest is not None:
            time = np.concatenate([self._rest[0], time])
            values = np.concatenate([self._rest[1], values], axis=1)
            first = self._rest[2]
        with np.errstate(invalid="ignore"):
            steps = np.diff(time)
            breaks = np.flatnonzero(~((steps > 0) & (steps < GAP * self.dt))) + 1
        self.gaps += len(breaks)
        edges = [0, *breaks.tolist(), len(time)]
        for k, (start, stop) in enumerate(pairwise(edges)):
            count = (stop - start) // self.size
            end = start + count * self.size
            if count:
                part = values[:, start:end].reshape(len(values), count, self.size)
                with np.errstate(over="ignore", invalid="ignore"):
                    self._means.append(part.mean(axis=2).T)
                self._time.append(time[start : end : self.size].copy())
                self._first.append(first + np.arange(start, end, self.size))
            if k < len(edges) - 2:
                self.left_out += stop - end
            else:
                self._rest = (time[end:].copy(), values[:, end:].copy(), first + end)

    def result(self) -> Windows:
        """All windows so far."""
        rest = 0 if self._rest is None else len(self._rest[0])
        empty = np.empty((0, 0 if self._rest is None else len(self._rest[1])))
        return Windows(
            time=np.concatenate([np.empty(0), *self._time]),
            first=np.concatenate([np.empty(0, dtype=np.int64), *self._first]),
            means=np.concatenate(self._means) if self._means else empty,
            size=self.size,
            dt=self.dt,
            left_out=self.left_out + rest,
        )
