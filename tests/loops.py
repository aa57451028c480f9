"""Loops that several optics tests run through; parameters of `fogkit.optics.Loop`."""

LOOPS = {
    "unit gain": {},
    "low gain": {"gain": 0.2},
    "delay": {"gain": 0.4, "delay": 2},
    "two integrators": {"gain": 0.5, "second_gain": 0.05},
    "two integrators, delay": {"gain": 0.3, "second_gain": 0.02, "delay": 1},
    "mirrored": {"bias_order": "mirrored"},
    "balanced": {"gain": 0.7, "bias_order": "balanced"},
}
