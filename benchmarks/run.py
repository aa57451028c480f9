"""The benchmarks, each beside a peer or a bound in the same run: ``make bench``.

Every figure is the median of several runs after a warm-up. Nothing here is asserted: a machine may be slow.
"""

import multiprocessing
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pandas as pd
import psutil
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet as pq

from fogkit import io
from fogkit.calibration import bench_fit, multiposition, three_stage
from fogkit.calibration.navigation_based import calibrate
from fogkit.campaign import grid, map_cases, run_campaign
from fogkit.cli.entry import main as command_line
from fogkit.imu import Construction, GyroTriad, LinearTriad, MeasurementUnit, Sensors, SizeEffect
from fogkit.imu.tables import IMU_COLUMNS
from fogkit.navigation import State, increments_from_motion, integrate, integrate_arrays
from fogkit.noise import RandomErrors, allan_deviation, identify
from fogkit.noise import simulate as simulate_errors
from fogkit.optics import ClosedLoopGyro, simulate
from fogkit.optics.measure import simulated_drift
from fogkit.optics.motion import AngularOscillation
from fogkit.reproduction.miklyashev import FIGURE_1_ACCELERATION, SIMULATED, SIMULATED_ACCELERATIONS
from fogkit.rotation import small_angle_between
from fogkit.stand import Laboratory, RateTable, RoughTable, bench, nine_tests, observations, plans, turn_recordings
from fogkit.units import ARCMIN, ARCSEC, DEG, DEG_PER_HOUR, DEG_PER_HOUR_PER_SQRT_HOUR, DEG_PER_SQRT_HOUR

OSCILLATION = AngularOscillation(acceleration=FIGURE_1_ACCELERATION, frequency=60.0)


def median_time(function: Callable[[], object], runs: int = 5) -> float:
    """Median wall time of a call, s, after one that is not counted."""
    function()
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return float(np.median(times))


def show(name: str, value: str, bound: str) -> None:
    """One line of the report."""
    print(f"{name:<66} {value:>16}   {bound}", flush=True)


def plain_python(gyro: ClosedLoopGyro, rates: list[float]) -> list[float]:
    """The exact loop as a plain loop over half-periods: the peer of the compiled one."""
    from math import cos, sin

    loop, to_phase = gyro.loop, gyro.coil.sagnac_scale_factor
    pattern = loop.bias_pattern[0].tolist()
    feedback, readings = to_phase * rates[0], []
    for start in range(0, len(rates), loop.half_periods):
        demodulated = 0.0
        for m, bias in enumerate(pattern):
            residual = to_phase * rates[start + m] - feedback
            demodulated -= bias * 0.5 * (1 + cos(residual + bias * loop.depth))
        readings.append(feedback / to_phase)
        feedback += loop.gain * demodulated / (0.5 * sin(loop.depth) * loop.half_periods)
    return readings


def samples_per_second() -> None:
    """Time per half-period, in memory, against the plain loop and with noise."""
    count = 2_000_000
    duration = count * SIMULATED.loop.half_period
    rates = OSCILLATION.sample(0, count, SIMULATED.loop.half_period)
    compiled = median_time(lambda: simulate.run(SIMULATED, OSCILLATION, duration)) / count
    short = rates[:160_000].tolist()
    plain = median_time(lambda: plain_python(SIMULATED, short), runs=3) / len(short)
    difference = np.abs(np.array(plain_python(SIMULATED, short)) - simulate.run(SIMULATED, rates[:160_000]).rate).max()
    show("simulator, exact response, one thread, per half-period", f"{compiled * 1e9:.1f} ns", "bound 30 ns")
    show("the same as a plain Python loop", f"{plain * 1e9:.0f} ns", f"{plain / compiled:.0f} times slower")
    show("largest difference of the two readings", f"{difference:.0e} rad/s", "rounding")
    linear = median_time(lambda: simulate.run(SIMULATED, OSCILLATION, duration, degree=1)) / count
    show("linear response", f"{linear * 1e9:.1f} ns", "")
    noisy = ClosedLoopGyro(coil=SIMULATED.coil, loop=SIMULATED.loop, detector_noise=1e-4)
    rng = np.random.default_rng(1)
    with_noise = median_time(lambda: simulate.run(noisy, OSCILLATION, duration, rng=rng)) / count
    show("exact response with detector noise", f"{with_noise * 1e9:.1f} ns", "")


def three_minutes() -> None:
    """The paper's run on the vibrator: 36 million half-periods, streamed; memory in a process of its own."""
    elapsed = median_time(lambda: simulated_drift(SIMULATED, OSCILLATION, 180.0), runs=3)
    show("3 minutes at 60 Hz, 36 million half-periods, streamed", f"{elapsed:.2f} s", "bound 1.5 s")
    memory = int(
        subprocess.run([sys.executable, __file__, "memory"], capture_output=True, text=True, check=True).stdout
    )
    show("peak memory of a process that does this and nothing else", f"{memory / 1e6:.0f} MB", "bound 300 MB")


def peak_memory() -> int:
    """Peak resident memory of this process, bytes."""
    info = psutil.Process().memory_info()
    if hasattr(info, "peak_wset"):  # Windows
        return info.peak_wset
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)


def sweep() -> None:
    """A sweep of accelerations, on one thread and on all."""
    cases = [
        {"gyro": SIMULATED, "oscillation": AngularOscillation(acceleration=float(a), frequency=60.0), "duration": 20.0}
        for a in SIMULATED_ACCELERATIONS
    ]
    elapsed = {}
    for workers in (1, os.cpu_count() or 1):
        with ThreadPoolExecutor(workers) as pool:
            elapsed[workers] = median_time(lambda: map_cases(simulated_drift, cases, executor=pool), runs=3)
    one, *rest = elapsed.values()
    all_workers = rest[0] if rest else one
    show(f"sweep of {len(cases)} accelerations, 20 s each, one thread", f"{one:.2f} s", "")
    show(f"the same on {max(elapsed)} threads", f"{all_workers:.2f} s", f"{one / all_workers:.1f} times faster")


def calibrations() -> None:
    """Complete calibrations of a triad: all positions and turns, all three axes, noise included."""
    triad = GyroTriad(
        bias=(0.15 * DEG_PER_HOUR, 0.0, -0.06 * DEG_PER_HOUR),
        scale_positive=(1.746892, 1.664746, 1.730345),
        scale_negative=(1.746890, 1.664747, 1.730357),
        misalignments=np.array([-2.9, 1.8, 2.3, 1.3, 2.4, 2.7]) * ARCMIN,
        angle_random_walk=0.1 * ARCSEC,
        bias_instability=0.002 * DEG_PER_HOUR,
    )
    table = RateTable(latitude=60 * DEG, readout_noise=2 * ARCSEC, latch_time_error=1e-6, rate_stability=5e-6)
    plan, rng = plans.three_stage(Construction(name="plain")), np.random.default_rng(1)

    def one() -> None:
        three_stage.calibrate(bench.run(plan, triad, table, rng=rng))

    at_once = median_time(lambda: three_stage.calibrate(bench.run(plan, triad, table, rng=rng, runs=1000)))
    in_turn = median_time(lambda: [one() for _ in range(1000)], runs=1)
    show("Monte Carlo of 1000 complete calibrations, three axes, at once", f"{at_once:.2f} s", "bound 30 s")
    show("the same one after the other", f"{in_turn:.2f} s", "bound 30 s")
    record = bench.run(plan, triad, table, rng=rng)
    predicted = median_time(lambda: three_stage.calibrate(record, noise=(triad, table)))
    show("one staged calibration with its covariance", f"{predicted * 1e3:.0f} ms", "")
    show("bench_fit.fit, one run", f"{median_time(lambda: bench_fit.fit(record, (triad, table))):.2f} s", "")


def random_errors() -> None:
    """Allan deviation of ten hours at 100 Hz against AllanTools; simulation and identification of such a record."""
    import allantools

    errors = RandomErrors(
        angle_random_walk=0.001 * DEG_PER_SQRT_HOUR,
        bias_instability=0.003 * DEG_PER_HOUR,
        rate_random_walk=0.01 * DEG_PER_HOUR_PER_SQRT_HOUR,
    )
    count, dt, rng = 3_600_000, 0.01, np.random.default_rng(1)
    rate = simulate_errors(errors, count, dt, rng)
    ours = median_time(lambda: allan_deviation(rate, dt))
    peer = median_time(lambda: allantools.oadev(rate, 1 / dt, "freq", "octave"), runs=3)
    difference = allan_deviation(rate, dt).deviation / allantools.oadev(rate, 1 / dt, "freq", "octave")[1] - 1
    show("overlapping Allan deviation, 3.6 million samples, octaves", f"{ours * 1e3:.0f} ms", "")
    show("the same by AllanTools", f"{peer * 1e3:.0f} ms", f"{peer / ours:.1f} times slower, bound 3")
    show("largest relative difference of the two", f"{np.abs(difference).max():.0e}", "bound 1e-9")
    show("simulation of that record", f"{median_time(lambda: simulate_errors(errors, count, dt, rng), 3):.1f} s", "")
    found = median_time(lambda: identify(rate, dt))
    show("identification of N, B and K with their covariance", f"{found * 1e3:.0f} ms", "")


def cones_and_rocks(angle: float, amplitude: float, frequency: float) -> tuple[Callable, Callable, Callable]:
    """Rate, specific force in body axes, and attitude in space of a body that cones and is shaken in step with it."""
    from scipy.spatial.transform import Rotation

    w = 2 * np.pi * frequency

    def rate(t):
        sine, cosine = np.sin(w * t), np.cos(w * t)
        return w * np.stack([-np.sin(angle) * sine, np.sin(angle) * cosine, np.full_like(t, np.cos(angle) - 1)], -1)

    def force(t):
        return np.stack([amplitude * np.sin(w * t), -amplitude * np.cos(w * t), np.full_like(t, 9.8)], -1)

    def attitude(t):
        return Rotation.from_rotvec(angle * np.stack([np.cos(w * t), np.sin(w * t), np.zeros_like(t)], -1))

    return rate, force, attitude


def navigation() -> None:
    """Strapdown mechanisation against the compiled kernel of pyins, on one truth of coning and sculling."""
    import warnings

    import pandas as pd
    from pyins import _numba_integrate, strapdown

    warnings.filterwarnings("ignore", message="The copy keyword is deprecated")  # in pyins, with pandas 3
    dt, steps = 0.01, 100_000
    rate, force, attitude = cones_and_rocks(1 * DEG, 5.0, 5.0)
    motion = increments_from_motion(rate, force, steps * dt, dt)
    finer = increments_from_motion(
        rate, force, steps * dt, dt / 10
    )  # the truth: ten times the steps, 1e-4 of the error
    start = State(lat=55 * DEG, C_b_n=attitude(np.zeros(1)).as_matrix()[0])
    truth = integrate(finer, start, every=10 * steps).state()

    swap = np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1]])  # right-forward-up to forward-right-down, east-north-up to NED
    columns = list(motion.columns)
    ned = np.hstack([motion[columns[:3]].to_numpy() @ swap, motion[columns[3:]].to_numpy() @ swap])
    # pyins wants one reading before the first, and times at the end of the steps
    before = 2 * ned[:1] - ned[1:2]
    readings = pd.DataFrame(np.vstack([before, ned]), columns=columns, index=dt * np.arange(steps + 1))
    names = ("lat", "lon", "alt", "VN", "VE", "VD", "roll", "pitch", "heading")
    first = integrate(motion.iloc[:2], start).to_frame().iloc[0] / ([DEG, DEG, 1, 1, 1, 1] + [DEG] * 3)
    begin = [first.lat, first.lon, 0.0, 0.0, 0.0, 0.0, first.roll, first.pitch, first.heading]
    begin = pd.Series(dict(zip(names, begin, strict=True)), name=0.0)

    def table_to_table() -> pd.DataFrame:
        return strapdown.Integrator(begin).integrate(strapdown.compute_increments_from_imu(readings, "increment"))

    prepared = strapdown.compute_increments_from_imu(readings, "increment")
    theta, dv = (np.ascontiguousarray(prepared[[f"{name}_{axis}" for axis in "xyz"]]) for name in ("theta", "dv"))
    lla, velocity, matrices = np.zeros((steps + 1, 3)), np.zeros((steps + 1, 3)), np.zeros((steps + 1, 3, 3))
    lla[0], matrices[0] = [first.lat, first.lon, 0.0], swap @ start.C_b_n @ swap
    durations = np.full(steps, dt)
    dtheta_ib_b, dv_ib_b = np.ascontiguousarray(motion[columns[:3]]), np.ascontiguousarray(motion[columns[3:]])

    def theirs() -> None:
        _numba_integrate.integrate(durations, lla, velocity, matrices, theta, dv, 0, True)

    # in turn, so that another load on the machine meets both
    ours, peer = [], []
    for _ in range(7):
        ours.append(median_time(lambda: integrate_arrays(dtheta_ib_b, dv_ib_b, dt, start), runs=1))
        peer.append(median_time(theirs, runs=1))
    ours, peer = np.median(ours) / steps, np.median(peer) / steps
    show(
        "navigation, compiled loop, per step",
        f"{ours * 1e9:.0f} ns",
        f"{peer / ours:.1f} times faster than pyins, goal 3",
    )
    ours, peer = [], []
    for _ in range(7):
        ours.append(median_time(lambda: integrate(motion, start).to_frame(), runs=1))
        peer.append(median_time(table_to_table, runs=1))
    ours, peer = np.median(ours) / steps, np.median(peer) / steps
    show("the same from table to table", f"{ours * 1e9:.0f} ns", f"{peer / ours:.1f} times faster than pyins, goal 5")

    end = integrate_arrays(dtheta_ib_b, dv_ib_b, dt, start, every=steps).state()
    attitude_errors = [
        np.linalg.norm(small_angle_between(C, truth.C_b_n)) / ARCSEC for C in (end.C_b_n, swap @ matrices[-1] @ swap)
    ]
    velocity_errors = [np.linalg.norm(v - truth.v_eb_n) for v in (end.v_eb_n, swap @ velocity[-1])]
    for name, (error, other), unit in (("attitude", attitude_errors, "arcsec"), ("velocity", velocity_errors, "m/s")):
        show(
            f"error of {name} after {steps * dt:g} s of coning and sculling",
            f"{error:.4g} {unit}",
            f"pyins {other:.4g}",
        )

    runs = np.broadcast_to(dtheta_ib_b[:3500], (90, 3500, 3)), np.broadcast_to(dv_ib_b[:3500], (90, 3500, 3))
    runs = tuple(np.ascontiguousarray(array) for array in runs)
    options = {"position_fixed": True, "keep_attitude": False, "velocity_reset": 20.0}
    batch = median_time(lambda: integrate_arrays(*runs, dt, start, **options)) / runs[0].size * 3
    show("90 recordings of 35 s at once, position fixed, per step", f"{batch * 1e9:.0f} ns", "")


def rough_table() -> None:
    """Nine tests on a rough turntable, recorded by a unit with delays and size effect, and noise drawn anew."""
    table, plan = RoughTable.typical(53.9 * DEG), nine_tests()
    white = RandomErrors(angle_random_walk=0.003 * DEG_PER_SQRT_HOUR)
    full = MeasurementUnit(
        gyros=Sensors(random=white, delay=(1e-3, 2e-3, 3e-3)),
        accelerometers=Sensors(random=white, delay=(2e-3, 2e-3, 4e-3)),
        size_effect=SizeEffect.one_point(0.02 * np.eye(3)),
    )
    for rate, bound in ((100.0, "bound 0.06 s"), (1000.0, "bound 0.6 s")):
        motions = table.motions(plan, np.random.default_rng(1))
        plain = median_time(lambda: turn_recordings.record(MeasurementUnit(), motions, rate))  # noqa: B023
        show(f"nine tests of 35 s at {rate:g} Hz on a rough table, without noise", f"{plain:.3f} s", bound)
        exact = turn_recordings.exact_inputs(full, motions, rate)
        again = median_time(lambda: exact.arrays(np.random.default_rng(2)))  # noqa: B023
        first = median_time(lambda: turn_recordings.exact_inputs(full, motions, rate))  # noqa: B023
        show("the same with four different delays and size effect", f"{first:.3f} s", "")
        show("random errors drawn anew", f"{again:.3f} s", "")


def noisy_calibration(seed: int) -> float:
    """One Monte Carlo run: noise drawn anew, calibration in full; the largest remaining correction."""
    calibration = calibrate(MONTE_CARLO.record(np.random.default_rng(seed)), nine_tests(), 53.9 * DEG)
    return float(calibration.log.largest_correction.iloc[-1])


def navigation_calibrations() -> None:
    """Calibrations by changes of velocity: nine tests of 35 s, eight iterations, table in and result out."""
    global MONTE_CARLO  # workers that are forked share it
    table, plan, rng = RoughTable.typical(53.9 * DEG), nine_tests(), np.random.default_rng(1)
    walk = RandomErrors(angle_random_walk=0.003 * DEG_PER_SQRT_HOUR)
    triads = [LinearTriad(matrix=np.eye(3) + 1e-3 * rng.normal(size=(3, 3))) for _ in range(2)]
    unit = MeasurementUnit(gyros=Sensors(triad=triads[0], random=walk), accelerometers=Sensors(triad=triads[1]))
    motions = table.motions(plan, rng)
    for rate, bound in ((1000.0, "bound 0.5 s"), (100.0, "")):
        recordings = turn_recordings.record(unit, motions, rate, rng=rng)
        elapsed = median_time(lambda: calibrate(recordings, plan, 53.9 * DEG))  # noqa: B023
        show(f"calibration by navigation, nine tests of 35 s at {rate:g} Hz, 8 iterations", f"{elapsed:.3f} s", bound)
    MONTE_CARLO = turn_recordings.exact_inputs(unit, motions, 100.0)
    start = time.perf_counter()
    with ProcessPoolExecutor(mp_context=multiprocessing.get_context("fork")) as pool:
        map_cases(noisy_calibration, [{"seed": seed} for seed in range(1000)], executor=pool)
    elapsed = time.perf_counter() - start
    show("1000 of them at 100 Hz, noise drawn anew, on all processors", f"{elapsed:.0f} s", "bound 60 s on 2")


def gyrocompass() -> None:
    """Filters of the rocked gyrocompass on 100 Hz data with an aid once a second, against that of pyins."""
    import warnings

    import pandas as pd
    from pyins import filters, inertial_sensor, measurements, strapdown

    from fogkit.gyrocompass.frames import TO_PACKAGE
    from fogkit.gyrocompass.mechanisation import hull_increments
    from fogkit.reproduction.lechang import filtering

    warnings.filterwarnings("ignore", message="The copy keyword is deprecated")  # in pyins, with pandas 3
    recording, fixes, noise, start, known = filtering.inputs(1, 10 * DEG, 0.01)[:5]
    steps = len(recording.dtheta)
    ours = {
        name: median_time(lambda f=f: f(recording, fixes, noise, start, known)) / steps
        for name, f in filtering.FILTERS.items()
    }

    # the same record for pyins, which knows no mount: increments of the hull, forward, right, down; the first 60 s
    short, dt = 6000, recording.dt
    hull = hull_increments(recording.dtheta[:short], recording.mount_angle[: short + 1])
    frd = np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1]]) @ TO_PACKAGE
    readings = np.hstack([hull @ frd.T, recording.dv[:short] @ frd.T])
    names = [f"{sensor}_{axis}" for sensor in ("gyro", "accel") for axis in "xyz"]
    table = pd.DataFrame(np.vstack([readings[:1], readings]), columns=names, index=dt * np.arange(short + 1))
    increments = strapdown.compute_increments_from_imu(table, "increment")
    v = start.velocity
    begin = pd.Series(
        {
            **{"lat": start.lat / DEG, "lon": start.lon / DEG, "alt": start.alt, "VN": v[0], "VE": v[2], "VD": -v[1]},
            **{"roll": start.roll / DEG, "pitch": start.trim / DEG, "heading": start.heading / DEG},
        },
        name=0.0,
    )
    heard = fixes.values[1:61]
    index = fixes.time[1:61]
    aids = [
        measurements.Position(
            pd.DataFrame({"lat": heard[:, 3] / DEG, "lon": heard[:, 4] / DEG, "alt": heard[:, 5]}, index=index), 3.0
        ),
        measurements.NedVelocity(
            pd.DataFrame({"VN": heard[:, 0], "VE": heard[:, 2], "VD": -heard[:, 1]}, index=index), 0.01
        ),
    ]
    gyros = inertial_sensor.EstimationModel(
        bias_sd=known.bias, noise=noise.angle_random_walk[0], scale_misal_sd=known.scale_factor * np.eye(3)
    )

    def theirs(time_step: float) -> None:
        filters.run_feedback_filter(
            begin, 10.0, 0.1, 0.1, 10.0, increments, gyro_model=gyros, measurements=aids, time_step=time_step
        )

    every = median_time(lambda: theirs(dt), runs=1) / short
    coarse = median_time(lambda: theirs(1.0), runs=1) / short
    for name, bound in (("extended", "15 states"), ("wander", "17 states")):
        each = ours[name]
        show(f"gyrocompass filter, {name}, {bound}, per second", f"{1 / each:.0f} steps", "goal 200 000")
        show(
            "pyins' feedback filter, covariance in each step as here",
            f"{1 / every:.0f} steps",
            f"{every / each:.0f} times slower, goal 20",
        )
        show("the same with covariance once a second", f"{1 / coarse:.0f} steps", f"{coarse / each:.1f} times slower")
    filtering.motion()
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        elapsed = median_time(lambda: filtering.thesis_runs(range(100), 0.01, executor=pool), runs=1)
    show("100 seeds of the thesis's run of 900 s at 100 Hz, on all threads", f"{elapsed:.1f} s", "bound 60 s on 2")


def write_six_positions(folder: Path, kind: str, count: int, rate: float) -> Path:
    """Recording of six positions with white noise, written piece by piece; path of its description."""
    laboratory, latitude = Laboratory(latitude=1.0), 1.0
    plan = io.PlanReference(kind="six-positions", parameters={"duration": count / 6 / rate})
    names = [*IMU_COLUMNS]
    description = io.RecordingDescription(
        file=io.FileFormat(path=f"data.{kind}", rows=count),
        clock=io.Clock(column="time", unit="s"),
        gyro=io.Channels(columns=names[:3], unit="rad/s"),
        accel=io.Channels(columns=names[3:], unit="m/s^2"),
        latitude=latitude,
        plan=plan,
    )
    (folder / "recording.toml").write_text(description.to_toml(), encoding="utf-8")
    schema = pa.schema([("time", pa.float64()), *((name, pa.float32()) for name in names)])
    rng, data = np.random.default_rng(1), folder / f"data.{kind}"
    writer = pq.ParquetWriter(data, schema) if kind == "parquet" else pyarrow.csv.CSVWriter(data, schema)
    with writer:
        done = 0
        for placement in plan.build().placements:
            inputs = np.concatenate(laboratory.mean_inputs(placement)).astype(np.float32)
            for first in range(0, count // 6, 500_000):
                n = min(500_000, count // 6 - first)
                noise = rng.standard_normal((6, n), dtype=np.float32)
                noise *= np.repeat(np.float32([1e-5, 1e-3]), 3)[:, None]
                columns = [(done + np.arange(n)) / rate, *(noise + inputs[:, None])]
                writer.write_table(pa.table(columns, schema=schema))
                done += n
    return folder / "recording.toml"


def survey_and_calibrate(path: str) -> None:
    """A long recording judged, reduced, Allan-analysed and calibrated; prints seconds and bytes at most in memory."""
    start = time.perf_counter()
    found = io.survey(path, reduced_rate=1.0, allan=True, progress="24 hours")
    if found.verdict.severity != "good" or found.segmentation is None:
        raise SystemExit(f"{found.verdict!r}")
    schedule = found.description.plan.build()
    observed = observations(*io.placed(found.reduced, found.segmentation, schedule), Laboratory(latitude=1.0))
    multiposition.calibrate_accelerometers(observed)
    print(time.perf_counter() - start, time.process_time(), peak_memory())


def recordings() -> None:
    """Recordings of users: 10 million rows of text in memory, 24 hours at 1 kHz in one pass."""
    with tempfile.TemporaryDirectory() as name:
        path = write_six_positions(Path(name), "csv", 9_999_996, 1000.0)

        def whole() -> None:
            recording = io.read(path)
            if io.check(recording).severity != "good" or len(io.segment(recording).segments) != 6:
                raise SystemExit("the recording of the benchmark is not judged as it should be")

        start = time.process_time()
        elapsed = median_time(whole, runs=1)
        processor = (time.process_time() - start) / 2
        peer = median_time(lambda: pd.read_csv(path.with_name("data.csv")), runs=1)
        show("text of 10 million rows, read, checked, segmented", f"{elapsed:.1f} s", "bound 20 s")
        show("processor time of that, all threads", f"{processor:.1f} s", "")
        show("pandas.read_csv of the same file", f"{peer:.1f} s", f"{peer / elapsed:.1f} times as long")
    with tempfile.TemporaryDirectory() as name:
        path = write_six_positions(Path(name), "parquet", 86_400_000, 1000.0)
        command = [sys.executable, __file__, "survey", str(path)]
        told = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout
        elapsed, processor, memory = map(float, told.split())
        show("24 h, 1 kHz, 6 axes: reduced, Allan, calibrated", f"{elapsed:.0f} s", f"processor {processor:.0f} s")
        show("peak memory of a process that does this and nothing else", f"{memory / 1e6:.0f} MB", "bound 2000 MB")


def campaigns() -> None:
    """What a stored and seeded run costs beside its function, against a plain loop and against results in memory."""
    count = 5000
    levels = {"length": np.linspace(500.0, 1500.0, count)}
    lengths = grid(levels)

    def stored(workers: ThreadPoolExecutor | ProcessPoolExecutor) -> None:
        with tempfile.TemporaryDirectory() as folder:
            run_campaign(coil_with_noise, lengths, folder, seed=1, executor=workers, progress=False)

    cases = [{"length": float(length), "rng": np.random.default_rng(1)} for length in levels["length"]]
    plain = median_time(lambda: [coil_with_noise(**case) for case in cases], runs=3) / count
    show(f"a function of microseconds in a plain loop of {count}, each", f"{plain * 1e6:.0f} us", "")
    for name, kind in (("thread", ThreadPoolExecutor), ("process", ProcessPoolExecutor)):
        with kind(1) as pool:
            mapped = median_time(lambda: map_cases(coil_with_noise, cases, executor=pool), runs=3) / count
            kept = median_time(lambda: stored(pool), runs=3) / count
        show(f"the same by map_cases, one {name}, beyond that", f"{(mapped - plain) * 1e6:.0f} us", "")
        show(f"the same as a campaign, seeded and stored, one {name}", f"{(kept - plain) * 1e6:.0f} us", "")


def coil_with_noise(length: float, rng: np.random.Generator) -> float:
    """A cheap case."""
    return length + float(rng.standard_normal())


COMMANDS = {  # words of the command line, each after the simulation of its own recording if there is one
    "check": ("multiposition", "check {d}/recording.toml"),
    "allan": ("allan", "allan {d}/recording.toml"),
    "calibrate multiposition": ("multiposition", "calibrate multiposition {d}/recording.toml"),
    "calibrate rate-sequence": ("rate-sequence", "calibrate rate-sequence {d}/recording.toml"),
    "calibrate three-stage": ("three-stage", "calibrate three-stage {d}/recording.toml"),
    "calibrate navigation": ("navigation", "calibrate navigation {d}/recording.toml"),
    "thermal": ("thermal", "thermal {d}/recording.toml"),
    "north": ("north", "north {d}/recording.toml"),
    "drift": (None, "drift"),
    "apply": ("multiposition", "apply {d}/found.json {d}/recording.toml {d}/corrected"),
    "verify": ("multiposition", "verify {d}/found.json {d}/truth.json"),
    "simulate multiposition": (None, "simulate multiposition {d} --overwrite"),
    "plan": (None, "plan twenty-four-points"),
}


def commands() -> None:
    """Each command of the command line in a process of its own, start of Python included: time and peak memory."""
    elapsed = median_time(lambda: subprocess.run([sys.executable, "-m", "fogkit", "--help"], stdout=subprocess.DEVNULL))
    show("fogkit --help", f"{elapsed:.2f} s", "bound 0.3 s")
    with tempfile.TemporaryDirectory() as name:
        for method in {method for method, _ in COMMANDS.values() if method}:
            folder = f"{name}/{method}"
            one_command(f"simulate {method} {folder}")
        one_command(
            f"calibrate multiposition {name}/multiposition/recording.toml --output {name}/multiposition/found.json"
        )
        for title, (method, words) in COMMANDS.items():
            line = (
                words.format(d=f"{name}/{method or 'more'}") + f" --output {name}/result.json --report {name}/page.html"
            )
            one_command(line)  # compiled code is stored
            seconds, memory = one_command(line)
            show(f"fogkit {title}, with report", f"{seconds:.1f} s", f"{memory / 1e6:.0f} MB at most")


def one_command(line: str) -> tuple[float, int]:
    """Wall time, s, and peak memory, bytes, of one command line in a process of its own."""
    start = time.perf_counter()
    done = subprocess.run([sys.executable, __file__, "command", *line.split()], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"fogkit {line}\n{done.stderr}")
    return time.perf_counter() - start, int(done.stdout.split()[-1])


def import_time() -> None:
    """Importing the package, against starting Python."""

    def start(code: str) -> float:
        return median_time(lambda: subprocess.run([sys.executable, "-c", code], check=True), runs=5)

    bare, package, optics = start("pass"), start("import fogkit"), start("import fogkit.optics.simulate")
    show("import fogkit, beyond starting Python", f"{package - bare:.3f} s", "bound 0.3 s")
    show("import fogkit.optics.simulate, beyond starting Python", f"{optics - bare:.2f} s", "")


def main() -> None:
    """Run all benchmarks."""
    print(f"Python {sys.version.split()[0]}, {os.cpu_count()} processors\n")
    samples_per_second()
    three_minutes()
    sweep()
    calibrations()
    random_errors()
    navigation()
    rough_table()
    navigation_calibrations()
    gyrocompass()
    recordings()
    campaigns()
    commands()
    import_time()


if __name__ == "__main__":
    if sys.argv[1:] == ["memory"]:
        simulated_drift(SIMULATED, OSCILLATION, 180.0)
        print(peak_memory())
    elif sys.argv[1:2] == ["command"]:
        code = command_line([*sys.argv[2:], "--quiet"])
        print(peak_memory())
        sys.exit(code)
    elif sys.argv[1:2] == ["survey"]:
        survey_and_calibrate(sys.argv[2])
    else:
        main()
