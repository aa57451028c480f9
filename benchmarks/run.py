"""The benchmarks, each beside a peer or a bound in the same run: ``make bench``.

Every figure is the median of several runs after a warm-up. Nothing here is asserted: a machine may be slow.
"""

import os
import subprocess
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import psutil

from fogkit.calibration import bench_fit, three_stage
from fogkit.campaign import map_cases
from fogkit.imu import Construction, GyroTriad
from fogkit.noise import RandomErrors, allan_deviation, identify
from fogkit.noise import simulate as simulate_errors
from fogkit.optics import ClosedLoopGyro, simulate
from fogkit.optics.measure import simulated_drift
from fogkit.optics.motion import AngularOscillation
from fogkit.reproduction.miklyashev import FIGURE_1_ACCELERATION, SIMULATED, SIMULATED_ACCELERATIONS
from fogkit.stand import RateTable, bench, plans
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
    import_time()


if __name__ == "__main__":
    if sys.argv[1:] == ["memory"]:
        simulated_drift(SIMULATED, OSCILLATION, 180.0)
        print(peak_memory())
    else:
        main()
