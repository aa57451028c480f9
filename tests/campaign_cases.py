"""What the campaigns of the tests run: in a module of its own, so that workers and other processes can import it."""

import os
import threading
import time
from dataclasses import dataclass

import numpy as np

from fogkit.campaign import grid, run_campaign


@dataclass(frozen=True, kw_only=True)
class Gyro:
    """Something to hand to every case."""

    noise: float
    axes: tuple[str, ...] = ("x", "y")


def noisy_mean(bias, count, rng):
    """Mean and deviation of a noisy bias."""
    values = bias + rng.standard_normal(count)
    return {"mean": values.mean(), "deviation": values.std()}


def scaled(value, gyro=None):
    """A deterministic function."""
    return value * (1.0 if gyro is None else gyro.noise)


def inverse(value):
    """Fails at zero."""
    return 1 / value


def given(values):
    """Returns what it is given."""
    return values


def odd(kind):
    """Results of all kinds, some of which cannot be stored."""
    return {
        "array": np.arange(3.0),
        "record": Gyro(noise=0.5),
        "large": 2**60 + 1,
        "none": None,
        "flag": np.True_,
        "text": "µ \ud800",
        "nan": float("nan"),
        "complex": 1j,
        "entries": {"a": 1, "b": [1, 2]},
        "keys": {1: 2},
    }[kind]


def flaky(path, times):
    """Fails the first times that it is called with a path; tells its random number, which a retry must not change."""
    with open(path, "a", encoding="utf-8") as file:
        file.write("x")
    if os.path.getsize(path) <= times:
        raise OSError("not yet")
    return os.path.getsize(path)


LET_GO = threading.Event()


def held_back(value):
    """The first run ends at once, any other when it is let go."""
    if value:
        LET_GO.wait(30)
    return value


def dies(value):
    """Takes its worker with it."""
    if value == 3:
        os._exit(1)
    return value


def slow_mean(bias, rng):
    """A run that takes long enough to be killed in."""
    time.sleep(0.02)
    return rng.standard_normal() + bias


def slow_campaign(folder, executor):
    """Forty of them, each stored as it comes."""
    cases = grid({"bias": range(40)})
    return run_campaign(slow_mean, cases, folder, seed=3, executor=executor, interval=0, progress=False)
