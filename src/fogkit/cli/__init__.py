"""The command line ``fogkit``: recordings in, results and reports out.

Every command is a function from parsed arguments to a `results.Result`, or to the files that it writes. `entry` parses,
runs, prints, writes the result as JSON and as a report, and turns errors into sentences and exit codes: 0 done, 1 bad
data, 2 bad usage, 130 interrupted. Nothing heavy is loaded before a command runs, so that ``fogkit --help`` is quick.

=====================  ============================================================================
module                 answers
=====================  ============================================================================
`entry`                what happens from the command line to the exit code?
`arguments`            which commands and options are there, and what do they say of themselves?
`results`              what is a result, and how does it go to JSON and back exactly?
`summaries`            how does a result read on a screen, in the units of the field?
`files`                how is a file written whole or not at all, and which one was read?
`loading`              what is read of a recording before a command works on it?
`inspection`           ``check`` and ``allan``: is it sound, and how does it drift?
`placed_calibrations`  ``calibrate multiposition`` and ``rate-sequence``
`turned_calibrations`  ``calibrate three-stage`` and ``navigation``
`corrections`          ``apply``: how does a result correct a recording?
`verification`         ``verify``: does a result agree with what is known?
`methods`              which plan does each method take, unless told otherwise?
`simulated_units`      which unit is simulated, and what should its calibration find?
`simulated_records`    what does it record while a plan is carried out?
`simulation`           ``simulate``: a recording with its truth
`schedules`            ``plan``: what does the operator do?
`heading`              ``north``: where is it, by gyros at rest?
`temperature`          ``thermal``: which temperatures does a gyro depend on?
`shaking`              ``drift``: what does angular acceleration do to a closed-loop gyro?
`report`               how does a result become one page with figures?
`figures`              which figures does it have?
=====================  ============================================================================
"""
