"""What else disturbs the calibration, by symbols: faces of the cube, an axis not quite to the east, one cooling curve.

And two conventions: what a ring of light senses, and which way the angles of the slides count.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from fogkit.reproduction.beihang.derivation import equivalent_and_cosines, regression, tilt_symbols
from fogkit.reproduction.beihang.points import positions, vertical_axis

if TYPE_CHECKING:
    from sympy import Expr, Matrix


# Faces of the cube that are not square to its axes: the error turns with the body


def face_errors() -> Matrix:
    """First-order errors of an accelerometer: zero term and three components, by small rotations of the six faces.

    The small rotation of face k, ``e_kx, e_ky, e_kz``, takes the axes of the body away from those of the cube.
    """
    import sympy as sp

    g = tilt_symbols()[0]
    k0 = sp.Symbol("K_0", real=True)
    K = sp.Matrix(sp.symbols("K_x K_y K_z", real=True))
    readings = [k0 + g * K.dot(vertical_axis(name) - face(name).cross(vertical_axis(name))) for name in positions()]
    return (regression(sp.Matrix(readings)) - sp.Matrix([k0, *K])).applyfunc(sp.expand)


def face(name: str) -> Matrix:
    """Small rotation of the face of a position."""
    import sympy as sp

    return sp.Matrix(sp.symbols(f"e_{name}x e_{name}y e_{name}z", real=True))


def common_face_error_turns_the_frame() -> bool:
    """Whether one and the same rotation of all faces leaves zero term and equivalent and turns the components."""
    import sympy as sp

    e = sp.Matrix(sp.symbols("e_x e_y e_z", real=True))
    K = sp.Matrix(sp.symbols("K_x K_y K_z", real=True))
    same = {symbol: value for name in positions() for symbol, value in zip(face(name), e, strict=True)}
    errors = face_errors().subs(same)
    return (
        errors[0] == 0
        and (errors[1:, :] - e.cross(K)).applyfunc(sp.expand).is_zero_matrix
        and sp.expand(errors[1:, :].dot(K)) == 0  # the length is kept to first order
    )


def opposite_faces_disturb_zero_term() -> Expr:
    """Error of the zero term if only the face of x up is off, to first order."""
    others = {symbol: 0 for name in positions() if name != "1" for symbol in face(name)}
    return face_errors()[0].subs(others)


def unequal_tilts_are_of_second_order() -> bool:
    """Whether another tilt of the plate in every position disturbs an accelerometer in the second order at most."""
    import sympy as sp

    g = tilt_symbols()[0]
    tilts, k0 = sp.symbols("delta_1:7", real=True), sp.Symbol("K_0", real=True)
    K = sp.Matrix(sp.symbols("K_x K_y K_z", positive=True))
    readings = [k0 + g * sp.cos(t) * K.dot(vertical_axis(name)) for t, name in zip(tilts, positions(), strict=True)]
    found = regression(sp.Matrix(readings))
    parts = [found[0], *equivalent_and_cosines(found[1:, :])[1]]
    level = dict.fromkeys(tilts, 0)
    return all(sp.simplify(sp.diff(part, tilt).subs(level)) == 0 for part in parts for tilt in tilts)


def gyro_zero_error_by_unequal_tilts() -> Expr:
    """Error of the zero term of a gyro if every position has a tilt of its own towards north, to first order."""
    import sympy as sp

    _, w, lat, *_ = tilt_symbols()
    tilts, c = sp.symbols("delta_1:7", real=True), sp.Matrix(sp.symbols("c_x c_y c_z", real=True))
    changes = [
        w * sp.cos(lat) * tilt * c.dot(vertical_axis(name)) for tilt, name in zip(tilts, positions(), strict=True)
    ]
    return regression(sp.Matrix(changes))[0]


# One axis to the east


def east_bias_error() -> dict[str, Expr]:
    """Rate along an axis to the east, to first order in its azimuth error (to the north) and its elevation, 1 rad."""
    import sympy as sp

    _, w, lat, *_ = tilt_symbols()
    azimuth, elevation = sp.symbols("epsilon theta", real=True)
    east, north, up = sp.cos(elevation) * sp.cos(azimuth), sp.cos(elevation) * sp.sin(azimuth), sp.sin(elevation)
    rate = 0 * east + w * sp.cos(lat) * north + w * sp.sin(lat) * up
    at_east = {azimuth: 0, elevation: 0}
    return {
        "nominal": rate.subs(at_east),
        "azimuth": sp.diff(rate, azimuth).subs(at_east),
        "elevation": sp.diff(rate, elevation).subs(at_east),
    }


def east_pair_cancels() -> bool:
    """Whether the mean of an axis to the east and to the west, its errors turning with the body, has no Earth rate."""
    import sympy as sp

    _, w, lat, *_ = tilt_symbols()
    azimuth = sp.Symbol("epsilon", real=True)
    rate = w * sp.cos(lat) * sp.sin(azimuth)
    return sp.simplify(rate + rate.subs(azimuth, azimuth + sp.pi)) == 0


# What a gyro senses, and which way an angle counts


def sagnac_delay() -> Expr:
    """Difference of the travel times of light round a ring of radius r with and against its rotation at a rate."""
    import sympy as sp

    r, w, c, t = sp.symbols("r omega c t", positive=True)
    times = [sp.solve(sp.Eq(c * t, 2 * sp.pi * r + sign * r * w * t), t)[0] for sign in (1, -1)]
    return sp.simplify(times[0] - times[1])


def angles_towards_third_axis() -> dict[str, int]:
    """Sign of each misalignment angle counted towards the third axis, against the right-handed turn about its axis.

    Key: turned axis, then the axis that it is turned about.
    """
    import sympy as sp

    def unit(i):
        return sp.Matrix([int(i == k) for k in range(3)])

    return {"xyz"[i] + "xyz"[j]: int(unit(j).cross(unit(i))[3 - i - j]) for i in range(3) for j in range(3) if i != j}


def one_cooling_rate_is_collinear() -> bool:
    """Whether temperature and its rate are collinear with a constant while one exponential goes to its end."""
    import sympy as sp

    end, change, tau, t = sp.symbols("T_end Delta tau t", positive=True)
    temperature = end - change * sp.exp(-t / tau)
    columns = sp.Matrix([[1, temperature, sp.diff(temperature, t)]])
    wronskian = sp.Matrix.vstack(columns, columns.diff(t), columns.diff(t, 2)).det()
    return sp.simplify(wronskian) == 0
