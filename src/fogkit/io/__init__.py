"""Recordings of measurement units on disk: read, judged, segmented, reduced, written.

A recording is a file of numbers and a small text beside it, ``recording.toml``, that says what they are. `read` makes
the one table of it (SI and radians, body axes, index ``time``), `check` says whether it is sound and in the right
units, `segment` when the unit rested and turned, and which step of the plan that was. `survey` does all of it in one
pass over a recording larger than memory. What cannot be used ends in a `RecordingError` of one sentence.

==================  =====================================================================================
module              answers
==================  =====================================================================================
`errors`            what is raised when a recording cannot be used?
`plain_toml`        how are plain values written as TOML?
`unit_names`        which units have a name, and what are they in SI?
`plan_names`        which plans have a name, and what does the unit feel in each of their steps?
`description`       what does ``recording.toml`` say?
`readers`           what stands in a file of text, Parquet, NPZ or MATLAB, piece by piece?
`recordings`        what is that in SI and body axes?
`windows`           what are the means over windows, from one block after the other?
`verdicts`          what was found wrong, in words and as a table?
`quality`           gaps, jitter, repeats, frozen and clipped channels, missing numbers, steps, clock drift?
`segmentation`      when did the unit rest and turn, and which step of the plan was that?
`units_check`       are the units right, and if not, by which factor are they wrong?
`streams`           all of that in one pass, with the recording reduced and its Allan deviation
`handover`          what does each calibration take of it?
`writing`           how is a recording written, so that it reads back?
==================  =====================================================================================
"""

from fogkit.io.description import Channels, Clock, FileFormat, RecordingDescription, read_description
from fogkit.io.errors import RecordingError
from fogkit.io.handover import bench_record, dwell_means, placed, turn_tables
from fogkit.io.plan_names import MountScan, PlanReference
from fogkit.io.recordings import Recording, read
from fogkit.io.segmentation import Segmentation, segment
from fogkit.io.streams import Survey, check, reduce, survey
from fogkit.io.units_check import check_units
from fogkit.io.verdicts import Finding, Verdict
from fogkit.io.writing import describe, write

__all__ = [
    "Channels",
    "Clock",
    "FileFormat",
    "Finding",
    "MountScan",
    "PlanReference",
    "Recording",
    "RecordingDescription",
    "RecordingError",
    "Segmentation",
    "Survey",
    "Verdict",
    "bench_record",
    "check",
    "check_units",
    "describe",
    "dwell_means",
    "placed",
    "read",
    "read_description",
    "reduce",
    "segment",
    "survey",
    "turn_tables",
    "write",
]
