"""Which plan does each method take, unless told otherwise, and what else may be changed in a plan?"""

import tomllib
from collections.abc import Sequence
from typing import Any

from fogkit.cli.arguments import UsageError
from fogkit.io.errors import first_sentence
from fogkit.io.plan_names import PlanReference
from fogkit.stand import placements

KINDS: dict[str, tuple[str, ...]] = {
    "multiposition": ("placements", "six-positions", "twenty-four-points", "full-turns"),
    "rate-sequence": ("rate-sequence",),
    "three-stage": ("three-stage",),
    "navigation": ("nine-tests",),
    "north": ("gyrocompass",),
    "allan": ("placements",),
}
"""Plans of each method, the one that `simulate` takes first."""

_EXAMPLES = {"gyrocompass": "north", "placements": "multiposition"}


def default_plan(method: str, duration: float | None = None) -> PlanReference:
    """Plan of a method: the one of its paper, or for ``allan`` one position.

    Parameters
    ----------
    method : str
        A key of `KINDS`.
    duration : float, optional
        Duration of each position, dwell or rate, s; that of the paper if not given.
    """
    if method == "multiposition":
        length = {} if duration is None else {"duration": duration}
        plan = placements.six_positions(**length) + placements.full_turns()
        rows = [[p.label, p.axes, p.duration, p.rate] for p in plan.placements]
        return PlanReference(kind="placements", parameters={"placements": rows, "rate_unit": "rad/s"})
    if method == "allan":
        row = ["rest", "ENU", 3600.0 if duration is None else duration, 0.0]
        return PlanReference(kind="placements", parameters={"placements": [row]})
    if method == "north":
        values = {"start": "ENU", "axis": "z", "angles": [0.0, 90.0, 180.0, 270.0], "angle_unit": "deg"}
        dwell = 300.0 if duration is None else duration
        return PlanReference(kind="gyrocompass", parameters=values | {"dwell": dwell, "turn_duration": 10.0})
    name = {"three-stage": "bias_duration", "rate-sequence": "duration", "navigation": "dwell"}[method]
    return PlanReference(kind=KINDS[method][0], parameters={} if duration is None else {name: duration})


def chosen_plan(kind: str, parameters: Sequence[str]) -> PlanReference:
    """Plan by its name and ``name=value`` texts; values are written as in TOML. Plans without defaults are
    those of `simulate` if nothing is given.

    Raises
    ------
    UsageError
        If a text is none of these, or the plan cannot be built.
    """
    if not parameters and kind in _EXAMPLES:  # these have no defaults
        return default_plan(_EXAMPLES[kind])
    values: dict[str, Any] = {}
    for text in parameters:
        name, sign, value = text.partition("=")
        if not sign:
            raise UsageError(f"a parameter of a plan must be NAME=VALUE, got {text!r}")
        try:
            values[name.strip()] = tomllib.loads(f"value = {value}")["value"]
        except tomllib.TOMLDecodeError:
            values[name.strip()] = value.strip()  # text without its quotes
    try:
        return PlanReference(kind=kind, parameters=values)
    except (ValueError, TypeError) as error:
        raise UsageError(f"the plan {kind!r} cannot be built: {first_sentence(error)}") from None
