"""What is read of a recording before a command works on it: table, verdict, segments, plan, place."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fogkit.cli.files import described, versions
from fogkit.cli.results import Estimates, Result
from fogkit.io import recordings, streams
from fogkit.io.description import RecordingDescription
from fogkit.io.errors import RecordingError
from fogkit.io.plan_names import AnyPlan
from fogkit.io.quality import Monitor
from fogkit.io.segmentation import Segmentation
from fogkit.io.verdicts import Finding, Verdict
from fogkit.stand.laboratory import Laboratory


@dataclass(frozen=True, kw_only=True, eq=False)
class Loaded:
    """A recording in memory that may be used.

    Attributes
    ----------
    path : Path
        Of its description.
    recording : fogkit.io.Recording
        The recording.
    verdict : Verdict
        Its findings, none of them bad.
    segmentation : Segmentation
        Its dwells and turns, named by its plan.
    """

    path: Path
    recording: recordings.Recording
    verdict: Verdict
    segmentation: Segmentation

    @property
    def plan(self) -> AnyPlan:
        """The plan that was carried out; `RecordingError` if the description has none."""
        reference = self.recording.description.plan
        if reference is None:
            raise RecordingError(
                f"{self.path.name} must say in [plan] what was done: `fogkit plan --help` has the plans"
            )
        return reference.build()

    @property
    def latitude(self) -> float:
        """Latitude, rad; `RecordingError` if the description has none."""
        if self.recording.description.latitude is None:
            raise RecordingError(f"{self.path.name} must give the latitude in [place]")
        return self.recording.description.latitude

    @property
    def laboratory(self) -> Laboratory:
        """The place without errors."""
        gravity = self.recording.description.gravity
        return Laboratory(latitude=self.latitude, gravity=0.0 if gravity is None else gravity)

    def result(
        self,
        command: str,
        *,
        estimates: Estimates | None = None,
        findings: Sequence[Finding] = (),
        parameters: dict[str, Any] | None = None,
        tables: dict[str, Any] | None = None,
        correction: dict[str, Any] | None = None,
    ) -> Result:
        """Result of a command on this recording, with its checks, its files and all versions."""
        description = self.recording.description
        about = {"samples": len(self.recording.table), "dt": self.recording.dt, **_place(description)}
        return Result(
            command=command,
            estimates=Estimates() if estimates is None else estimates,
            findings=[*self.verdict.findings, *findings],
            inputs=inputs(self.path, description),
            parameters=about | (parameters or {}),
            versions=versions(),
            tables=tables or {},
            correction=correction,
        )


def load(path: str | Path, kinds: Sequence[str] = (), method: str = "") -> Loaded:
    """Read, judge and segment a recording.

    Parameters
    ----------
    path : str or Path
        Of the description, ``recording.toml``.
    kinds : sequence of str, optional
        Plans of which it must be one; by default any, or none.
    method : str, optional
        What needs such a plan, for the error.

    Returns
    -------
    Loaded

    Raises
    ------
    RecordingError
        If it cannot be read, is not usable, or is of another plan.
    """
    recording = recordings.read(Path(path))
    plan = recording.description.plan
    if kinds and (plan is None or plan.kind not in kinds):
        came = "none" if plan is None else repr(plan.kind)
        raise RecordingError(f"{method} needs a recording of the plan {' or '.join(kinds)}, got {came} in [plan]")
    monitor = Monitor(recording.description, recording.dt)
    monitor.update(recording.block())
    verdict, segmentation = streams.judge(monitor, recording.description)
    verdict.require_usable()
    if segmentation is None:  # a bad finding says why, always
        raise RecordingError(f"no dwells and turns were found in {Path(path).name}")
    return Loaded(path=Path(path), recording=recording, verdict=verdict, segmentation=segmentation)


def inputs(path: Path, description: RecordingDescription) -> list[dict[str, Any]]:
    """Description and data file of a recording."""
    return [described(path), described(path.parent / description.file.path)]


def _place(description: RecordingDescription) -> dict[str, Any]:
    place = {"latitude": description.latitude, "gravity": description.gravity}
    plan = {} if description.plan is None else {"plan": {"kind": description.plan.kind, **description.plan.parameters}}
    return {key: value for key, value in place.items() if value is not None} | plan
