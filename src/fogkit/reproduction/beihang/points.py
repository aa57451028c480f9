"""Attitudes of the 24 points: three letters among E W N S U D say where the axes x, y, z of the body point."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fogkit.reproduction.beihang import slides

if TYPE_CHECKING:
    from sympy import Matrix

_DIRECTIONS = {"E": (1, 0, 0), "W": (-1, 0, 0), "N": (0, 1, 0), "S": (0, -1, 0), "U": (0, 0, 1), "D": (0, 0, -1)}
_LETTERS = {direction: letter for letter, direction in _DIRECTIONS.items()}


def attitude(label: str) -> Matrix:
    """``C_b_n`` of an attitude of three letters: its columns are the axes of the body in east, north, up."""
    import sympy as sp

    return sp.Matrix([_DIRECTIONS[letter] for letter in label]).T


def is_right_handed(label: str) -> bool:
    """Whether the axes of an attitude form a right-handed frame."""
    return attitude(label).det() == 1


def points(axis: int, up: bool) -> tuple[str, ...]:
    """The four attitudes of a position: one axis up or down, the axis after it to east, south, west, north."""
    import sympy as sp

    labels = []
    for letter in slides.POINTS_OF_THE_CIRCLE:
        axes = [sp.zeros(3, 1)] * 3
        axes[axis], axes[(axis + 1) % 3] = (sp.Matrix(_DIRECTIONS[one]) for one in ("U" if up else "D", letter))
        axes[(axis + 2) % 3] = axes[axis].cross(axes[(axis + 1) % 3])
        labels.append("".join(_LETTERS[tuple(column)] for column in axes))
    return tuple(labels)


def positions() -> dict[str, tuple[str, ...]]:
    """The six positions, x up, x down, y up, ... with their points: the printed rule carried on to y and z."""
    return {
        str(2 * axis + 2 - up): points(axis, bool(up))  # 1 and 2 for x up and down, 3 and 4 for y, ...
        for axis in range(3)
        for up in (1, 0)
    }


def attitudes() -> dict[str, str]:
    """The 24 attitudes by the names that the slides give the first eight."""
    return {f"{name}-{k}": label for name, labels in positions().items() for k, label in enumerate(labels, start=1)}


def quarter_turns(labels: tuple[str, ...]) -> bool:
    """Whether each attitude follows from the one before, and the first from the last, a quarter turn clockwise."""
    import sympy as sp

    clockwise = sp.Matrix([[0, 1, 0], [-1, 0, 0], [0, 0, 1]])
    return all(
        clockwise * attitude(first) == attitude(second)
        for first, second in zip(labels, (*labels[1:], labels[0]), strict=True)
    )


def vertical_axis(name: str) -> Matrix:
    """Body axes that point up in a position: plus or minus one on one axis."""
    import sympy as sp

    index = int(name) - 1
    direction = sp.zeros(3, 1)
    direction[index // 2] = -1 if index % 2 else 1
    return direction
