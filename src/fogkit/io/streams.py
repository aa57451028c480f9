"""Recordings larger than memory: one pass that judges, reduces, segments, and takes the Allan deviation.

Memory holds one block of samples, the means over windows, and the reduced recording.
"""

import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fogkit import checks
from fogkit.imu.tables import GYRO_COLUMNS
from fogkit.io import readers
from fogkit.io.description import RecordingDescription
from fogkit.io.errors import RecordingError
from fogkit.io.quality import Monitor, step_findings
from fogkit.io.recordings import Block, Recording, blocks, located
from fogkit.io.segmentation import Segmentation, segment_windows
from fogkit.io.units_check import unit_findings
from fogkit.io.verdicts import Verdict
from fogkit.io.windows import WindowMeans
from fogkit.noise import AllanDeviation
from fogkit.noise.allan import octaves

Array = NDArray[np.float64]

SHORT = 1024
"""Largest averaging factor whose Allan variance is of all samples; from means over `STRIDE` samples beyond."""

STRIDE = 128
"""Samples of those means: second differences then begin every `STRIDE` samples instead of every sample, at most 1/16 of
the averaging time apart, which costs few of their degrees of freedom."""

REDUCED_RATE = 1.0
"""Samples per second of the reduced recording, unless told otherwise."""


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Survey:
    """What one pass over a recording leaves.

    Attributes
    ----------
    description : RecordingDescription
        Of the recording.
    count : int
        Samples.
    dt : float
        Sampling time, s.
    verdict : Verdict
        Soundness, units and, with a plan, what was done.
    segmentation : Segmentation or None
        Dwells and turns; None if they cannot be found, and then `verdict` says why.
    reduced : Recording
        Means over equal numbers of samples, at a lower rate: sums of increments, divided by their time.
    allan : AllanDeviation or None
        Of the gyros, rad/s; None if it was not asked for.
    """

    description: RecordingDescription
    count: int
    dt: float
    verdict: Verdict
    segmentation: Segmentation | None
    reduced: Recording
    allan: AllanDeviation | None

    def __repr__(self) -> str:
        length = self.count * self.dt
        return f"<Survey of {self.count} samples, {length:.6g} s; {self.segmentation!r}>\n{self.verdict!r}"


def survey(
    source: str | Path | RecordingDescription,
    *,
    folder: str | Path = ".",
    reduced_rate: float = REDUCED_RATE,
    allan: bool = False,
    rows: int = readers.ROWS,
    progress: bool | str = False,
) -> Survey:
    """One pass over a recording of any length.

    Parameters
    ----------
    source, folder
        As for `fogkit.io.read`.
    reduced_rate : float, optional
        Samples per second of the reduced recording, Hz; the nearest whole number of samples is averaged.
    allan : bool, optional
        Whether to take the overlapping Allan deviation of the gyros, at all powers of two.
    rows : int, optional
        Samples in memory at a time. MATLAB files are loaded whole all the same.
    progress : bool or str, optional
        Whether to show a progress bar, or its label.

    Returns
    -------
    Survey

    Raises
    ------
    RecordingError
        If description or file cannot be used, or the Allan deviation is asked for of a recording with gaps, missing
        numbers or a frozen gyro.

    Warns
    -----
    UserWarning
        If samples before gaps fill no mean of the reduced recording, with their number.
    """
    description, folder = located(source, folder)
    rows = checks.integer("rows", rows, minimum=1)
    reduced_rate = checks.positive("reduced_rate", reduced_rate, "Hz")
    monitor = reduced = collector = dt = None
    count = 0
    with _bar(description, progress) as bar:
        for block in blocks(description, folder, rows):
            if monitor is None:
                dt = block.dt
                monitor = Monitor(description, dt)
                reduced = WindowMeans(max(1, round(1 / (reduced_rate * dt))), dt)
                collector = _AllanSums(dt) if allan else None
            monitor.update(block)
            reduced.update(block)
            if collector is not None:
                collector.update(block)
            count += len(block.time)
            bar.update(len(block.time))
    verdict, segmentation = judge(monitor, description)
    if collector is not None and reduced.gaps:
        raise RecordingError(f"{description.file.path} has {reduced.gaps} gaps: an Allan deviation needs equal steps")
    return Survey(
        description=description,
        count=count,
        dt=dt,
        verdict=verdict,
        segmentation=segmentation,
        reduced=_reduced(description, reduced),
        allan=None if collector is None else collector.result(),
    )


def check(recording: Recording) -> Verdict:
    """Whether a recording is sound, in the right units, and that of its plan.

    Parameters
    ----------
    recording : Recording
        The recording.

    Returns
    -------
    Verdict
        Findings; those on units, and on the plan, follow those on the samples.
    """
    checks.instance("recording", recording, Recording)
    monitor = Monitor(recording.description, recording.dt)
    monitor.update(recording.block())
    return judge(monitor, recording.description)[0]


def judge(monitor: Monitor, description: RecordingDescription) -> tuple[Verdict, Segmentation | None]:
    """Verdict on all samples that a monitor has seen, and the segmentation it rests on."""
    from fogkit.io.verdicts import Finding

    found = monitor.findings()
    try:
        segmentation = segment_windows(
            monitor.windows.result(), description.plan, description.accel is not None, monitor.labels
        )
    except RecordingError as error:
        return Verdict((*found, Finding(check="plan", severity="bad", text=str(error)))), None
    found += [*step_findings(segmentation, description.names), *unit_findings(description, segmentation)]
    return Verdict((*found, *segmentation.verdict.findings)), segmentation


def reduce(recording: Recording, rate: float) -> Recording:
    """Recording at a lower rate: means over equal numbers of samples, which are sums of increments over their time.

    Parameters
    ----------
    recording : Recording
        The recording.
    rate : float
        Samples per second wanted, Hz; the nearest whole number of samples is averaged.

    Returns
    -------
    Recording
        Its times are those at which the first sample of each mean begins. Labels are not kept.

    Warns
    -----
    UserWarning
        As `survey`.
    """
    checks.instance("recording", recording, Recording)
    means = WindowMeans(max(1, round(1 / (checks.positive("rate", rate, "Hz") * recording.dt))), recording.dt)
    means.update(recording.block())
    return _reduced(recording.description, means)


def _reduced(description: RecordingDescription, means: WindowMeans) -> Recording:
    import pandas as pd

    windows = means.result()
    if not len(windows.time):
        raise RecordingError(f"{description.file.path} is shorter than one sample of the reduced recording")
    if means.gaps and windows.left_out:
        text = f"{windows.left_out} samples of {description.file.path} before {means.gaps} gaps and at the end fill no "
        warnings.warn(text + "mean of the reduced recording and are left out", stacklevel=3)
    index = pd.Index(windows.time, name="time")
    table = pd.DataFrame(windows.means, index=index, columns=list(description.names))
    return Recording(table=table, description=description, dt=windows.duration)


class _AllanSums:
    """Overlapping Allan variances of the gyros, block by block."""

    def __init__(self, dt: float) -> None:
        self.dt, self.count = dt, 0
        self.factors = [m for m in (1 << k for k in range(40)) if m <= SHORT]
        self.sums = np.zeros((len(self.factors), 3))
        self.tail: list[Array] = [np.zeros(1)] * 3
        self.offset: Array | None = None
        self.means = WindowMeans(STRIDE, dt)
        self.low, self.high = np.full(3, np.inf), np.full(3, -np.inf)

    def update(self, block: Block) -> None:
        """Take one more block."""
        from fogkit.noise import _kernels

        rates = np.ascontiguousarray(block.values[:3])
        if not (np.abs(rates) < 1e150).all():
            raise RecordingError("an Allan deviation needs numbers, got missing, infinite or impossible ones")
        if self.offset is None:
            self.offset = rates.mean(axis=1)  # a constant changes no second difference
        self.low, self.high = np.minimum(self.low, rates.min(axis=1)), np.maximum(self.high, rates.max(axis=1))
        n = rates.shape[1]
        for c in range(3):
            angle = np.empty(n + 1)
            _kernels.angle(rates[c], self.offset[c], angle)
            joined = np.concatenate([self.tail[c][:-1], angle + self.tail[c][-1]])
            for k, m in enumerate(self.factors):
                fresh = min(n, len(joined) - 2 * m)  # differences that end in this block
                if fresh > 0:
                    part = joined[len(joined) - fresh - 2 * m :]
                    self.sums[k, c] += fresh * _kernels.second_difference_power(part, m)
            self.tail[c] = joined[-(2 * SHORT + 1) :].copy()
        self.count += n
        self.means.update(Block(np.arange(n) * self.dt + block.first * self.dt, rates, None, block.first, self.dt))

    def result(self) -> AllanDeviation:
        """Deviations at all powers of two up to half of the recording."""
        from fogkit.noise import _kernels

        if self.count < 2:
            raise RecordingError("an Allan deviation needs at least 2 samples")
        if (frozen := self.low == self.high).any():
            name = GYRO_COLUMNS[int(np.argmax(frozen))]
            raise RecordingError(f"an Allan deviation needs readings that vary, got a frozen {name}")
        factors = np.array(octaves(self.count))
        variance = np.empty((len(factors), 3))
        means = self.means.result().means
        angles = []
        for column in means.T:
            angle = np.empty(len(means) + 1)
            _kernels.angle(np.ascontiguousarray(column), column.mean() if len(means) else 0.0, angle)
            angles.append(angle)
        kept = []
        for k, m in enumerate(factors.tolist()):
            if m <= SHORT:
                variance[k] = self.sums[k] / (2.0 * m**2 * (self.count - 2 * m + 1))
                kept.append(k)
            elif len(means) >= 2 * (m // STRIDE):
                coarse = m // STRIDE
                variance[k] = [_kernels.second_difference_power(a, coarse) / (2.0 * coarse**2) for a in angles]
                kept.append(k)
        factors = factors[kept]
        return AllanDeviation(
            tau=factors * self.dt,
            deviation=np.sqrt(variance[kept]),
            factors=factors,
            differences=self.count - 2 * factors + 1,
            count=self.count,
            dt=self.dt,
        )


def _bar(description: RecordingDescription, progress: bool | str) -> Any:
    """Progress bar over samples, or something that takes its calls."""
    from tqdm import tqdm

    label = progress if isinstance(progress, str) else Path(description.file.path).name
    return tqdm(total=description.file.rows, desc=label, unit=" samples", unit_scale=True, disable=not progress)
