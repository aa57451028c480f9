"""Is a recording sound? Gaps, jitter, repeats, frozen and clipped channels, missing numbers, steps, clock drift.

`Monitor` takes a recording block by block and keeps only counts and means over windows, so that a recording larger than
memory is judged as one in memory is.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fogkit.imu.tables import ACCEL_COLUMNS, GYRO_COLUMNS
from fogkit.io.description import RecordingDescription
from fogkit.io.recordings import Block
from fogkit.io.segmentation import Segmentation, label_runs
from fogkit.io.verdicts import Finding, summary
from fogkit.io.windows import GAP, WindowMeans, Windows

Array = NDArray[np.float64]

WINDOW = 0.5
"""Duration, s, of the windows of which means are kept; one sample at least."""

JITTER = 0.1
"""Root mean square of the steps of the time about their mean, in sampling times, from which a clock is doubtful."""

FROZEN = 5
"""Fewest equal samples, one after the other, that can be a frozen channel."""

FROZEN_OVER_CHANCE = 3.0
"""How many times longer than the longest run that chance makes a frozen one is."""

REPEATED_ROWS = 0.01
"""Share of rows, all channels equal to the row before, from which they are called repeats."""

EDGE_OVER_NEXT, EDGE_DEVIATIONS, EDGE_COUNT = 2.5, 4.0, 10
"""As in `fogkit.stand.means`: how many times, and standard deviations, more often than the next reading the largest one
of a clipped channel comes; and how often at least."""

QUANTIZED = 0.5
"""Share of samples equal to the one before from which a channel is one of few levels: it may stand at its edge."""

LARGEST = {"gyro": 1000.0, "accel": 10_000.0, "temperature": 1000.0, "angle": 1e9, "clock": 1e15}
"""Readings, rad/s, m/s^2, degC, rad and s, that no sensor gives."""

COLDEST, HOTTEST = -90.0, 200.0
"""Temperatures, degC, outside of which a unit of temperature is doubtful."""

STEP = 12.0
"""Change of the level within a dwell, in standard deviations of the same statistic elsewhere, that counts as a step."""

TURNING = 3.5e-4
"""Change of a gyro's level, rad/s, that may be a turn that begins: 0.02 deg/s."""

STEP_SPAN = 6
"""Windows on each side of a step over which the level is taken."""

CLOCK_DRIFT = 100e-6
"""Relative drift of two clocks against each other that is doubtful: crystals are better."""

STAMP_DIGITS = 0.01
"""Resolution of the time in double precision, in sampling times, above which stamps have lost their digits."""


class Monitor:
    """Judges a recording from its blocks.

    Parameters
    ----------
    description : RecordingDescription
        What the recording is.
    dt : float
        Sampling time, s.
    """

    def __init__(self, description: RecordingDescription, dt: float) -> None:
        from fogkit.io import _kernels

        self.description, self.dt = description, dt
        self.names = description.names
        self.windows = WindowMeans(max(1, round(WINDOW / dt)), dt)
        state = np.zeros((len(self.names), _kernels.WIDTH))
        state[:, _kernels.LAST] = np.nan
        state[:, [_kernels.MAX, _kernels.NEXT_MAX]] = -np.inf
        state[:, [_kernels.MIN, _kernels.NEXT_MIN]] = np.inf
        self._state, self._row = state, np.full(6 if description.accel else 3, np.nan)
        self._limits = np.array([LARGEST[name.split("_")[0]] for name in self.names])
        self.labels: list | None = None
        self._count = self._repeated = 0
        self._last = np.nan
        self._first_time = np.nan
        # steps of the time: gaps, missing samples, not advancing, squares about dt, their number and sum, the largest
        self._gaps: list[float] = []
        self._stuck: list[float] = []
        self._lost = self._usual = self._gap_count = self._stuck_count = self._bad_stamps = 0
        self._square = self._sum = self._largest = self._time_size = 0.0

    def update(self, block: Block) -> None:
        """Take one more block."""
        from fogkit.io import _kernels

        _kernels.scan(block.values, float(block.first), self._limits, self._state)
        motion = np.ascontiguousarray(block.values[: len(self._row)])
        self._repeated += _kernels.repeated_rows(motion, self._row)
        if self.description.clock.column is not None:
            self._clock(block.time)
        self.labels = label_runs(block, self.labels or ())
        self._count += len(block.time)
        self.windows.update(block)

    def _clock(self, time: Array) -> None:
        finite = np.isfinite(time)
        self._bad_stamps += int(len(time) - np.count_nonzero(finite))
        time = time[finite]
        if not time.size:
            return
        if self._first_time != self._first_time:
            self._first_time = float(time[0])
        steps = np.diff(time, prepend=self._last) / self.dt
        steps, before = (steps[1:], time[:-1]) if np.isnan(self._last) else (steps, np.append(self._last, time[:-1]))
        self._last = float(time[-1])
        self._time_size = max(self._time_size, float(np.abs(time).max()))
        stuck = np.flatnonzero(steps <= 0)
        gaps = np.flatnonzero(steps >= GAP)
        self._stuck_count += len(stuck)
        self._gap_count += len(gaps)
        self._stuck += before[stuck[:20]].tolist()
        self._gaps += before[gaps[:20]].tolist()
        self._lost += sum(max(0, round(s) - 1) for s in np.minimum(steps[gaps], 1e15).tolist())
        usual = steps[(steps > 0) & (steps < GAP)] - 1
        self._usual += len(usual)
        self._square += float(usual @ usual)
        self._sum += float(usual.sum())
        self._largest = max(self._largest, float(np.abs(usual).max(initial=0.0)))

    def findings(self) -> list[Finding]:
        """All findings of the checks of this module."""
        windows = self.windows.result()
        found = [*self._stamps(), *self._clock_drift(windows), *self._missing(), *self._repeats()]
        found += [*self._spikes(), *self._frozen(), *self._clipped()]
        return found

    def _stamps(self) -> list[Finding]:
        if self.description.clock.column is None:
            counted = self.description.file.rows is not None
            text = "no clock was recorded, " + ("but all samples are there" if counted else "so losses cannot be seen")
            return [Finding(check="gaps", severity="good" if counted else "doubtful", text=text)]
        found = []
        if self._bad_stamps:
            found.append(_bad("gaps", f"{self._bad_stamps} time stamps are no numbers", count=self._bad_stamps))
        if self._gap_count:
            text = f"{self._gap_count} gaps with some {self._lost} samples lost, the first after {self._gaps[0]:.9g} s"
            found.append(_bad("gaps", text, count=self._gap_count, time=self._gaps[0]))
        found = summary("gaps", found, "no gap")
        if self._stuck_count:
            text = f"{self._stuck_count} time stamps do not advance, the first after {self._stuck[0]:.9g} s"
            found.append(_bad("time", text, count=self._stuck_count, time=self._stuck[0]))
        digits = float(np.spacing(self._time_size)) / self.dt
        if digits > STAMP_DIGITS:
            text = (
                f"time stamps near {self._time_size:.6g} s resolve only {digits:.2g} sampling times: subtract a start"
            )
            found.append(Finding(check="time", severity="doubtful", text=text))
        if self._usual:
            mean = self._sum / self._usual
            deviation = float(np.sqrt(max(0.0, self._square / self._usual - mean**2)))
            text = f"steps of the time scatter by {deviation:.2%} of the sampling time, at most {self._largest:.1%}"
            severity = "doubtful" if deviation > JITTER else "good"
            found.append(Finding(check="jitter", severity=severity, text=text))
            if abs(mean) > max(CLOCK_DRIFT, 3 * deviation / self._usual):  # the sum of steps telescopes
                text = (
                    f"the clock advances {mean * 1e6:+.0f} ppm more per sample than the sampling time of {self.dt:g} s"
                )
                found.append(Finding(check="clock drift", severity="doubtful", text=text, factor=1 + mean))
        return found

    def _clock_drift(self, windows: Windows) -> list[Finding]:
        if "clock" not in self.names or len(windows.time) < 3:
            return []
        second = windows.means[:, self.names.index("clock")]
        fine = np.isfinite(second) & np.isfinite(windows.time)
        first, second = windows.time[fine], second[fine]
        if len(first) < 3 or not np.ptp(first) > 0 or not np.isfinite(second).all():
            return [_bad("clock drift", "the second clock cannot be compared with the first")]
        x, y = first - first.mean(), second - second.mean()
        with np.errstate(over="ignore", invalid="ignore"):
            slope = float(x @ y / (x @ x))
            scatter = float(np.sqrt(np.mean((y - slope * x) ** 2)))
        if not np.isfinite([slope, scatter]).all() or not 0.5 < slope < 2:
            text = f"the second clock advances {slope:.6g} times as fast as the first: is a unit wrong?"
            return [_bad("clock drift", text, factor=slope)]
        text = f"the second clock gains {(slope - 1) * 1e6:+.1f} ppm on the first, scatter {scatter:.2g} s"
        severity = "doubtful" if abs(slope - 1) > CLOCK_DRIFT else "good"
        return [Finding(check="clock drift", severity=severity, text=text, factor=slope)]

    def _missing(self) -> list[Finding]:
        from fogkit.io import _kernels as k

        found = []
        for name, s in zip(self.names, self._state, strict=True):
            if s[k.BAD]:
                at = self._time_of(s[k.BAD_AT])
                text = f"{int(s[k.BAD])} numbers are missing or infinite, the first at {at:.9g} s"
                found.append(_bad("missing", text, name, count=int(s[k.BAD]), time=at))
            if s[k.HUGE]:
                at = self._time_of(s[k.HUGE_AT])
                text = f"{int(s[k.HUGE])} readings are beyond any sensor, up to {max(s[k.MAX], -s[k.MIN]):.3g}"
                found.append(_bad("range", text, name, count=int(s[k.HUGE]), time=at))
            if name.startswith("temperature") and not (s[k.MIN] >= COLDEST and s[k.MAX] <= HOTTEST) and s[k.COUNT]:
                text = f"reads {s[k.MIN]:.4g} to {s[k.MAX]:.4g} degC: is its unit right?"
                found.append(Finding(check="range", severity="doubtful", text=text, channel=name))
        return summary("missing", found, "every number is there, and finite")

    def _spikes(self) -> list[Finding]:
        from fogkit.io import _kernels as k

        found = []
        motion = self._state[: len(self._row)]
        for name, s, p in zip(self.names, motion, self._chance(motion), strict=False):
            ends_so = abs(s[k.BEFORE]) > k.SPIKE * s[k.SCALE]  # whether it would return is not known
            if ends_so and not s[k.SPIKES] and p < QUANTIZED and s[k.COUNT] > 2:
                found.append(
                    Finding(check="spikes", severity="doubtful", text="its last sample leaps", channel=name, count=1)
                )
            if s[k.SPIKES] and p < QUANTIZED:
                at = self._time_of(s[k.SPIKE_AT])
                text = f"{int(s[k.SPIKES])} samples leap by {k.SPIKE:g} times the usual change and back, the first at "
                text += f"{at:.9g} s, by up to {s[k.SPIKE_SIZE]:.3g}"
                count = int(s[k.SPIKES])
                found.append(
                    Finding(check="spikes", severity="doubtful", text=text, channel=name, count=count, time=at)
                )
        return summary("spikes", found, "no sample leaps and returns")

    def _repeats(self) -> list[Finding]:
        share = self._repeated / max(1, self._count)
        channels = self._state[: len(self._row)]
        noisy = self._chance(channels) < QUANTIZED
        if share <= REPEATED_ROWS or not noisy.all():
            enough = share <= REPEATED_ROWS or share < 0.5
            text = f"{share:.2%} of the rows repeat the one before"
            severity = "good" if enough else "doubtful"
            if share > 0.999:
                text = "no reading changes" if share == 1 else text + ": a recording without noise?"
            return [Finding(check="repeats", severity=severity, text=text, count=self._repeated)]
        text = f"{share:.1%} of the rows repeat the one before in all channels: logged twice, or faster than read"
        return [Finding(check="repeats", severity="doubtful", text=text, count=self._repeated)]

    @staticmethod
    def _chance(channels: Array) -> Array:
        """Share of samples that repeat the one before, outside the longest run."""
        from fogkit.io import _kernels as k

        outside = np.maximum(channels[:, k.COUNT] - channels[:, k.LONGEST], 1.0)
        return np.clip((channels[:, k.REPEATS] - np.maximum(channels[:, k.LONGEST] - 1, 0)) / outside, 0.0, 1.0)

    def _frozen(self) -> list[Finding]:
        from fogkit.io import _kernels as k

        found = []
        motion = self._state[: len(self._row)]
        chance = self._chance(motion)
        alone = np.count_nonzero(motion[:, k.LONGEST] >= np.maximum(motion[:, k.COUNT], 1)) < len(motion)
        for name, s, p in zip(self.names, motion, chance, strict=False):
            longest, count = int(s[k.LONGEST]), s[k.COUNT]
            if longest >= count > 1:
                severity = "bad" if alone else "doubtful"
                text = f"reads {s[k.MAX]:.9g} in all {longest} samples: a dead channel, or one without noise"
                found.append(Finding(check="frozen", severity=severity, text=text, channel=name, count=longest))
                continue
            usual = 1 + np.log(max(count, 2)) / -np.log(p) if 0 < p < 1 else 1.0
            if longest >= max(FROZEN, FROZEN_OVER_CHANCE * usual) and p < QUANTIZED:
                at = self._time_of(s[k.LONGEST_AT])
                text = (
                    f"stands still for {longest * self.dt:.4g} s at {at:.9g} s, where chance makes {usual:.0f} samples"
                )
                found.append(_bad("frozen", text, name, count=longest, time=at))
        return summary("frozen", found, "no channel stands still")

    def _clipped(self) -> list[Finding]:
        from fogkit.io import _kernels as k

        found = []
        motion = self._state[: len(self._row)]
        for name, s, p in zip(self.names, motion, self._chance(motion), strict=False):
            for edge, count, beside, run in (
                (s[k.MAX], s[k.MAX_COUNT], s[k.NEXT_MAX_COUNT], s[k.MAX_RUN]),
                (s[k.MIN], s[k.MIN_COUNT], s[k.NEXT_MIN_COUNT], s[k.MIN_RUN]),
            ):
                chance = EDGE_DEVIATIONS * np.sqrt(count + EDGE_OVER_NEXT**2 * beside)
                clipped = count >= max(EDGE_COUNT, EDGE_OVER_NEXT * beside + chance) and run >= 3
                if clipped and p < QUANTIZED and s[k.LONGEST] < s[k.COUNT]:
                    text = f"is clipped at {edge:.9g}, where {int(count)} samples stand"
                    found.append(_bad("clipped", text, name, count=int(count)))
        return summary("clipped", found, "no channel is clipped")

    def _time_of(self, sample: float) -> float:
        """Time of a sample by its number, gaps not counted, s."""
        start = 0.0 if np.isnan(self._first_time) else self._first_time
        return start + float(sample) * self.dt


def step_findings(segmentation: Segmentation, names: Sequence[str]) -> list[Finding]:
    """Sudden changes of a level that no turn explains: steps of single channels within a dwell."""
    return summary("steps", _steps(segmentation, names), "no step of a level within a dwell")


def _steps(segmentation: Segmentation, names: Sequence[str]) -> list[Finding]:
    windows = segmentation.windows
    span = STEP_SPAN
    columns = [i for i, name in enumerate(names) if name in (*GYRO_COLUMNS, *ACCEL_COLUMNS)]
    m = len(windows.time)
    if m < 8 * span:
        return []
    levels = windows.means[:, columns]
    if not np.isfinite(levels).all():
        return []
    sides = np.lib.stride_tricks.sliding_window_view(levels, span, axis=0)
    middle = np.median(sides, axis=-1)
    spread = np.ptp(sides, axis=-1)
    change = middle[span + 1 :] - middle[: -span - 1]  # a window that the step cuts is between
    noise = np.median(np.abs(change), axis=0) / 0.6745
    quiet = np.median(spread, axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        size = np.abs(change) / noise
        still = (spread[span + 1 :] < 4 * quiet) & (
            spread[: -span - 1] < 4 * quiet
        )  # both sides are dwells of all channels
    still = still.all(axis=1) & _within_dwells(segmentation, span)
    jump = (size > STEP) & still[:, None] & (noise > 0)
    found = []
    turning = np.abs(change) > [TURNING if names[c] in GYRO_COLUMNS else np.inf for c in columns]
    alone = (size > STEP / 2).sum(axis=1) == 1  # a change of attitude moves several channels at once
    for c, column in enumerate(columns):
        at = np.flatnonzero(jump[:, c] & alone & ~turning[:, c])
        others = np.convolve(jump.any(axis=1) & ~alone, np.ones(2 * span + 1), mode="same") > 0
        at = at[~others[at]]
        if at.size:
            worst = at[np.argmax(size[at, c])]
            text = (
                f"its level changes by {change[worst, c]:.3g} at {windows.time[worst + span]:.6g} s, "
                f"{size[worst, c]:.0f} standard deviations, while nothing else does"
            )
            time = float(windows.time[worst + span])
            found.append(
                Finding(check="steps", severity="doubtful", text=text, channel=names[column], count=1, time=time)
            )
    return found


def _within_dwells(segmentation: Segmentation, span: int) -> NDArray[np.bool_]:
    """For each pair of neighbouring spans of windows, whether both are in one dwell."""
    first = segmentation.windows.first
    inside = np.zeros(len(first) - 2 * span, dtype=bool)
    for s in segmentation.segments:
        if s.kind == "dwell":
            start, stop = np.searchsorted(first, [s.first, s.last - segmentation.windows.size + 1])
            inside[start : max(start, stop - 2 * span)] = True
    return inside


def _bad(check: str, text: str, channel: str = "", **more) -> Finding:
    return Finding(check=check, severity="bad", text=text, channel=channel, **more)
