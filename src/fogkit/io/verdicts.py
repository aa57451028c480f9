"""What was found wrong with a recording, so that it can be read."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from fogkit import checks
from fogkit.io.errors import RecordingError

if TYPE_CHECKING:
    from pandas import DataFrame

SEVERITIES = ("good", "doubtful", "bad")


@dataclass(frozen=True, kw_only=True)
class Finding:
    """One thing that was checked.

    Attributes
    ----------
    check : str
        What was checked: ``"gaps"``, ``"units"``, and so on.
    severity : {"good", "doubtful", "bad"}
        A doubtful one may be true of a sound recording; a bad one makes results wrong.
    text : str
        What was found, with its numbers.
    channel : str
        Column, or empty for all.
    count : int
        How often.
    time : float, or None
        Where first, s.
    factor : float, or None
        By which factor readings are off, for units: what they read over what they should.
    """

    check: str
    severity: str
    text: str
    channel: str = ""
    count: int = 0
    time: float | None = None
    factor: float | None = None

    def __post_init__(self) -> None:
        checks.option("severity", self.severity, SEVERITIES)


@dataclass(frozen=True, repr=False)
class Verdict:
    """All findings of a recording.

    Attributes
    ----------
    findings : tuple of Finding
        One at least for each check that could be made.
    """

    findings: tuple[Finding, ...] = field(default=())

    def __post_init__(self) -> None:
        object.__setattr__(self, "findings", tuple(self.findings))

    def __repr__(self) -> str:
        wrong = [f for f in self.findings if f.severity != "good"]
        head = f"{self.severity}: {len(self.findings)} checks, {len(wrong)} findings"
        lines = [f"  {f.severity:<8}  {f.check}{f', {f.channel}' * bool(f.channel)}: {f.text}" for f in wrong]
        return "\n".join([head, *lines])

    def __add__(self, other: "Verdict") -> "Verdict":
        return Verdict((*self.findings, *other.findings))

    @property
    def severity(self) -> str:
        """The worst of all findings."""
        return max((f.severity for f in self.findings), key=SEVERITIES.index, default="good")

    def of(self, check: str) -> tuple[Finding, ...]:
        """Findings of one check."""
        return tuple(f for f in self.findings if f.check == check)

    def require_usable(self) -> None:
        """`RecordingError` with the first bad finding, if there is one."""
        for finding in self.findings:
            if finding.severity == "bad":
                channel = f" of {finding.channel}" if finding.channel else ""
                raise RecordingError(f"the recording is not usable, {finding.check}{channel}: {finding.text}")

    def to_frame(self) -> "DataFrame":
        """One row for each finding, the worst first."""
        import pandas as pd

        ordered = sorted(self.findings, key=lambda f: -SEVERITIES.index(f.severity))
        columns = ["severity", "check", "channel", "text", "count", "time", "factor"]
        return pd.DataFrame([{c: getattr(f, c) for c in columns} for f in ordered], columns=columns)


def summary(check: str, findings: Iterable[Finding], good: str) -> list[Finding]:
    """Findings of a check, or one good one if there is none."""
    found = list(findings)
    return found or [Finding(check=check, severity="good", text=good)]
