"""Which commands and options there are, and what they say of themselves. Nothing heavy is imported here.

Every parser names its function as ``module:function``; `fogkit.cli.entry` imports it when it is called for.
"""

from argparse import ArgumentParser, ArgumentTypeError, RawDescriptionHelpFormatter, _SubParsersAction

from fogkit import __version__

PLANS = (
    *("three-stage", "six-positions", "twenty-four-points", "three-positions-east", "full-turns", "rate-sequence"),
    *("placements", "nine-tests", "bias-test", "gyrocompass"),
)
SIMULATED = ("multiposition", "rate-sequence", "three-stage", "navigation", "north", "allan", "thermal")
GRADES = ("tactical", "navigation")

TOUR = """\
a tour, from nothing to a verified calibration:
  fogkit simulate multiposition demo
  fogkit check demo/recording.toml
  fogkit calibrate multiposition demo/recording.toml --output found.json --report found.html
  fogkit apply found.json demo/recording.toml corrected
  fogkit check corrected/recording.toml
  fogkit verify found.json demo/truth.json

A recording of your own is a file of numbers and a recording.toml beside it that says what they are; `fogkit simulate`
writes an example. Exit codes: 0 done, 1 bad data, 2 bad usage, 130 interrupted."""


class UsageError(ValueError):
    """An argument that parses and cannot be used; the message is one sentence."""


def parser() -> ArgumentParser:
    """Parser of the whole command line."""
    root = ArgumentParser(
        prog="fogkit",
        description="Calibration of fibre-optic gyroscopes and of the units they are in, from recordings.",
        epilog=TOUR,
        formatter_class=RawDescriptionHelpFormatter,
    )
    root.add_argument("--version", action="version", version=f"fogkit {__version__}")
    commands = root.add_subparsers(title="commands", dest="command", metavar="COMMAND", required=True)
    _check(commands)
    _allan(commands)
    _calibrate(commands)
    _thermal(commands)
    _north(commands)
    _drift(commands)
    _apply(commands)
    _verify(commands)
    _simulate(commands)
    _plan(commands)
    return root


def positive(text: str) -> float:
    """A number above 0."""
    try:
        value = float(text)
    except ValueError:
        raise ArgumentTypeError(f"must be a number, got {text!r}") from None
    if not 0 < value < 1e12:
        raise ArgumentTypeError(f"must be a number above 0, got {text}")
    return value


def whole(text: str) -> int:
    """A whole number from 0 on."""
    if not (text.isascii() and text.isdigit() and len(text) < 10):
        raise ArgumentTypeError(f"must be a whole number from 0, got {text!r}")
    return int(text)


def latitude(text: str) -> float:
    """A latitude, deg."""
    try:
        value = float(text)
    except ValueError:
        value = 100.0
    if not -90 <= value <= 90:
        raise ArgumentTypeError(f"must be a latitude from -90 to 90 deg, got {text!r}")
    return value


def _command(
    commands: _SubParsersAction,
    name: str,
    run: str,
    short: str,
    text: str,
    example: str,
    then: str,
    source: bool = True,
) -> ArgumentParser:
    """A command that says what it does, how it is called, and what comes next."""
    epilog = f"example:\n  {example}\n\nnext:\n  {then}"
    made = commands.add_parser(
        name, help=short, description=text, epilog=epilog, formatter_class=RawDescriptionHelpFormatter
    )
    made.set_defaults(run=run)
    if source:
        made.add_argument("recording", metavar="RECORDING", help="description of a recording, recording.toml")
    made.add_argument("-o", "--output", metavar="FILE", help="write the result as JSON, which loads back exactly")
    made.add_argument("--report", metavar="FILE", help="write the result as one HTML page with figures")
    made.add_argument("-q", "--quiet", action="store_true", help="print nothing but errors")
    made.add_argument("--debug", action="store_true", help="show where an error arose")
    return made


def _check(commands: _SubParsersAction) -> None:
    made = _command(
        commands,
        "check",
        "inspection:check",
        "is a recording sound, in the right units, and that of its plan?",
        "Judges a recording of any length in one pass: gaps, jitter, repeats, frozen and clipped channels, missing\n"
        "numbers, steps, units (by gravity and the Earth's rotation), axes, and the steps of its plan.\n"
        "A recording that is not usable ends in exit code 1.",
        "fogkit check demo/recording.toml --report check.html",
        "`fogkit calibrate ...` with the method of the plan, or `fogkit allan` for a unit at rest",
    )
    _reduction(made)


def _allan(commands: _SubParsersAction) -> None:
    made = _command(
        commands,
        "allan",
        "inspection:allan",
        "Allan deviation of the gyros of a unit at rest, and the random errors in it",
        "Overlapping Allan deviation with confidence intervals, and from it angle random walk, bias instability and\n"
        "rate random walk with their covariance (IEEE 952). The unit must rest in one position.",
        "fogkit allan rest/recording.toml --output noise.json --report noise.html",
        "the angle random walk goes into `fogkit calibrate three-stage --gyro-noise`",
    )
    _reduction(made)


def _reduction(made: ArgumentParser) -> None:
    made.add_argument(
        "--rate", type=positive, default=1.0, metavar="HZ", help="samples per second of the reduced series (1)"
    )
    made.add_argument("--progress", action="store_true", help="show a progress bar")


def _calibrate(commands: _SubParsersAction) -> None:
    group = commands.add_parser(
        "calibrate",
        help="bias, scale factors and axes of a unit, by the method of its plan",
        description="Estimates with standard deviations and covariance, and the correction for `fogkit apply`.",
        epilog="example:\n  fogkit calibrate multiposition demo/recording.toml --output found.json\n\nnext:\n"
        "  `fogkit apply` corrects a recording, `fogkit verify` compares with a truth or another result",
        formatter_class=RawDescriptionHelpFormatter,
    )
    methods = group.add_subparsers(title="methods", dest="method", metavar="METHOD", required=True)
    then = "`fogkit apply found.json RECORDING FOLDER` corrects a recording with it"
    _command(
        methods,
        "multiposition",
        "placed_calibrations:multiposition",
        "positions on a plate, and turns: accelerometers and gyros",
        "Bias and matrix of each sensor by least squares, from positions held on a plate, and of the gyros from\n"
        "turns. Plans: placements, six-positions, twenty-four-points, full-turns.",
        "fogkit calibrate multiposition demo/recording.toml --output found.json",
        then,
    )
    made = _command(
        methods,
        "rate-sequence",
        "placed_calibrations:rate_sequence",
        "a sequence of rates on a single-axis table: gyros",
        "Scale factor, bias and, if wanted, the shape of the scale factor of each gyro; directions of the input axes\n"
        "from the turns at one rate. Plan: rate-sequence.",
        "fogkit calibrate rate-sequence demo/recording.toml --term asymmetry --output found.json",
        then,
    )
    made.add_argument(
        "--term",
        action="append",
        default=[],
        choices=("asymmetry", "quadratic", "cubic"),
        help="fit this too; may be repeated",
    )
    made.add_argument(
        "--rate-error", type=positive, default=0.0, metavar="R", help="relative standard deviation of the table's rates"
    )
    made.add_argument(
        "--installation-rate", type=positive, default=None, metavar="DEG_S", help="rate for the directions (150)"
    )
    made = _command(
        methods,
        "three-stage",
        "turned_calibrations:three_stage",
        "four positions and whole turns on a three-axis table: gyros",
        "Biases, scale factors of either sign and six misalignments of a gyro triad. The recording needs the readout\n"
        "of the table as `angle`. Plan: three-stage.",
        "fogkit calibrate three-stage demo/recording.toml --readout-noise 1 --output found.json",
        then,
    )
    _noise(made, "gyro", "deg/sqrt(h)")
    made.add_argument(
        "--readout-noise", type=float, default=0.0, metavar="ARCSEC", help="standard deviation of an angle read off (0)"
    )
    made = _command(
        methods,
        "navigation",
        "turned_calibrations:navigation",
        "dwells and turns on a rough turntable: everything but gyro biases",
        "Accelerometer biases and both matrices, from how the computed velocity changes over nine turns. The\n"
        "turntable may be worse than the unit. Plan: nine-tests.",
        "fogkit calibrate navigation demo/recording.toml --output found.json",
        then,
    )
    _noise(made, "gyro", "deg/sqrt(h)")
    _noise(made, "accel", "ug/sqrt(Hz)")
    for name, default, text in (
        ("azimuth-error", 0.1, "of the table's azimuth, common to all tests"),
        ("start-error", 0.15, "of the heading in which each test starts"),
    ):
        made.add_argument(
            f"--{name}", type=float, default=default, metavar="DEG", help=f"standard deviation {text}, deg ({default})"
        )
    made.add_argument("--iterations", type=whole, default=8, metavar="N", help="most iterations (8)")


def _noise(made: ArgumentParser, sensor: str, unit: str) -> None:
    made.add_argument(
        f"--{sensor}-noise",
        type=positive,
        default=None,
        metavar="N",
        help=f"white noise, {unit}; by default the longest dwell says it",
    )


def _thermal(commands: _SubParsersAction) -> None:
    made = _command(
        commands,
        "thermal",
        "temperature:thermal",
        "which temperatures does a gyro depend on, and how?",
        "Regression of a channel of a unit at rest on the recorded temperatures and their rates; points without a\n"
        "significant effect are dropped one after another.",
        "fogkit thermal run/recording.toml --channel gyro_x --output thermal.json",
        "`fogkit apply thermal.json RECORDING FOLDER` takes the effect out",
    )
    made.add_argument("--channel", default="gyro_x", help="what is modelled: gyro_x to accel_z (gyro_x)")
    made.add_argument("--window", type=positive, default=300.0, metavar="S", help="window of means and slopes, s (300)")
    made.add_argument("--keep-all", action="store_true", help="keep all measuring points")


def _north(commands: _SubParsersAction) -> None:
    _command(
        commands,
        "north",
        "heading:north",
        "where is north, from the Earth's rotation in dwells of the unit?",
        "Heading from gyros at rest at several angles of a mount, biases estimated along if the axis is upright.\n"
        "Plan: gyrocompass, axis level or upright. The heading is by how much the mount stands turned clockwise from\n"
        "what the letters of `start` say.",
        "fogkit north scan/recording.toml --output north.json",
        "`fogkit verify north.json scan/truth.json` for a simulated one",
    )


def _drift(commands: _SubParsersAction) -> None:
    made = _command(
        commands,
        "drift",
        "shaking:drift",
        "drift of a closed-loop gyro against angular acceleration",
        "Mean drift under harmonic angular oscillation and under constant acceleration, from coil and loop alone: no\n"
        "recording is needed.",
        "fogkit drift --length 1000 --diameter 0.1 --acceleration 500 5000 --frequency 60 --report drift.html",
        "chapter 3 of the book shows how gain, delay and bias order change it",
        source=False,
    )
    for name, default, text in (
        ("length", 1000.0, "fibre of the coil, m (1000)"),
        ("diameter", 0.1, "mean diameter of the coil, m (0.1)"),
        ("wavelength", 1.55, "um (1.55)"),
        ("depth", 0.75, "modulation depth, parts of pi rad (0.75)"),
        ("half-period", 5.0, "half-period of the modulation, us (5)"),
        ("gain", 1.0, "gain of the integrator (1)"),
        ("frequency", 60.0, "of the oscillation, Hz (60)"),
    ):
        made.add_argument(f"--{name}", type=positive, default=default, metavar="X", help=text)
    made.add_argument("--half-periods", type=whole, default=16, metavar="N", help="half-periods of a regulation (16)")
    made.add_argument(
        "--acceleration",
        type=positive,
        nargs="+",
        default=[500.0, 1000.0, 2000.0, 5000.0, 10000.0],
        metavar="A",
        help="amplitudes of the angular acceleration, deg/s^2",
    )


def _apply(commands: _SubParsersAction) -> None:
    made = _command(
        commands,
        "apply",
        "corrections:apply",
        "write a recording with its readings corrected by a result",
        "Corrects all samples of a recording, and writes it with its description into another folder: SI units, the\n"
        "form of the file, axes, plan and place as they were.",
        "fogkit apply found.json demo/recording.toml corrected",
        "`fogkit check corrected/recording.toml`, or calibrate it again: what is left should be noise",
        source=False,
    )
    made.add_argument("result", metavar="RESULT", help="result of a calibration, JSON")
    made.add_argument("recording", metavar="RECORDING", help="description of the recording to be corrected")
    made.add_argument("folder", metavar="FOLDER", help="where to write")


def _verify(commands: _SubParsersAction) -> None:
    made = _command(
        commands,
        "verify",
        "verification:verify",
        "does a result agree with a truth, or with another result?",
        "Compares all quantities that both have, against the covariance of both: each by itself and all together.\n"
        "Disagreement that chance makes once in 10 000 cases, or less, ends in exit code 1.",
        "fogkit verify found.json demo/truth.json",
        "a report shows the departures: --report verify.html",
        source=False,
    )
    made.add_argument("result", metavar="RESULT", help="result, JSON")
    made.add_argument("reference", metavar="REFERENCE", help="truth of `fogkit simulate`, or another result")


def _simulate(commands: _SubParsersAction) -> None:
    made = _command(
        commands,
        "simulate",
        "simulation:simulate",
        "write a recording with known truth, to try everything at once",
        "Writes recording.toml, the data, and truth.json, into a folder: what a unit with random errors records while\n"
        "the plan of a method is carried out.",
        "fogkit simulate multiposition demo --seed 2 --format parquet",
        "`fogkit check demo/recording.toml`, then the command of the method",
        source=False,
    )
    made.add_argument("method", metavar="METHOD", choices=SIMULATED, help=f"one of {', '.join(SIMULATED)}")
    made.add_argument("folder", metavar="FOLDER", help="where to write; made if need be")
    made.add_argument("--seed", type=whole, default=1, metavar="N", help="of the random numbers (1)")
    made.add_argument("--latitude", type=latitude, default=60.0, metavar="DEG", help="deg (60)")
    made.add_argument("--sample-rate", type=positive, default=None, metavar="HZ", help="samples per second")
    made.add_argument("--duration", type=positive, default=None, metavar="S", help="of each position, dwell or rate, s")
    made.add_argument("--grade", choices=GRADES, default=None, help="how good the unit is")
    made.add_argument(
        "--heading", type=float, default=None, metavar="DEG", help="of the mount, for `north`; drawn if not"
    )
    made.add_argument("--format", choices=("csv", "parquet", "npz", "matlab"), default="csv", help="of the data (csv)")
    made.add_argument("--plan", choices=PLANS, default=None, metavar="KIND", help="another plan that the method takes")
    _parameter(made)
    made.add_argument("--overwrite", action="store_true", help="replace a recording that is there")


def _plan(commands: _SubParsersAction) -> None:
    made = _command(
        commands,
        "plan",
        "schedules:plan",
        "schedule for the operator: table, CSV, and [plan] for recording.toml",
        f"Prints what is to be done step by step, and the lines for recording.toml that say so.\n"
        f"Plans: {', '.join(PLANS[:6])},\n{', '.join(PLANS[6:])}.",
        "fogkit plan six-positions --parameter duration=60 --csv schedule.csv",
        "record, describe in recording.toml, and `fogkit check recording.toml`",
        source=False,
    )
    made.add_argument("kind", metavar="KIND", choices=PLANS, help="name of the plan")
    _parameter(made)
    made.add_argument("--csv", metavar="FILE", help="write the schedule as CSV")


def _parameter(made: ArgumentParser) -> None:
    made.add_argument(
        "-p",
        "--parameter",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="parameter of the plan, as in [plan]: duration=60.0, or rates=[10.0, -10.0]; may be repeated",
    )
