"""One whole instrument, from the photodetector to heading: what does each calibration leave of each error?

==================  =====================================================================================
module              answers
==================  =====================================================================================
`description`       what is the unit, and what do its surroundings make of it?
`grades`            which units are there as examples, and how does one of a grade come out?
`stands`            which tables are there as examples, and how does one come out?
`methods`           what does each method of calibration say of the unit on a table?
`temperature`       what does a temperature test of the whole unit say?
`errors_left`       what is left of each error when the unit goes to sea?
`heading`           what does that do to heading, with the mount at rest and rocked?
`study`             all of it, for all grades, tables and methods
==================  =====================================================================================
"""

from fogkit.instrument.description import Conditions, Instrument
from fogkit.instrument.errors_left import PARTS, ErrorsLeft, errors_left
from fogkit.instrument.grades import GRADES, Grade
from fogkit.instrument.methods import METHODS, Calibrated, calibrate
from fogkit.instrument.stands import STANDS, Stand

__all__ = [
    "GRADES",
    "METHODS",
    "PARTS",
    "STANDS",
    "Calibrated",
    "Conditions",
    "ErrorsLeft",
    "Grade",
    "Instrument",
    "Stand",
    "calibrate",
    "errors_left",
]
