"""The layers of the package, held by reading its imports.

Each rule is a function that takes the folder of a package and returns its violations, one line each. The rules run on
`fogkit` itself and, so that they are known to be able to fail, on small trees that break them.
"""

import ast
import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

SOURCE = Path(__file__).resolve().parents[1] / "src" / "fogkit"

# From the ground up: a module imports from its own folder and from what stands before it here, whichever line it is on.
# `__main__` is `python -m fogkit`.
LAYERS = (
    *("constants", "units", "checks", "results"),
    *("rotation", "earth"),
    "estimation",
    *("noise", "optics", "thermal", "imu", "stand"),
    *("navigation", "calibration", "gyrocompass"),
    *("instrument", "campaign"),
    *("claims", "reproduction"),  # the ledger, and what fills it (called by name)
    *("datasets", "io", "plotting", "cli", "__main__"),
)
HEAVY = ("matplotlib", "pandas", "numba", "control", "scipy")
OUTSIDE = ("book", "tests", "benchmarks")
KERNEL_IMPORTS = ("__future__", "math", "numba", "numpy")


@dataclass(frozen=True)
class Import:
    """One imported module: who imports it, which, where, and whether only for a type checker."""

    source: str
    target: str
    place: str
    typing_only: bool = False

    @property
    def package(self) -> str:
        return self.target.partition(".")[0]


def modules(root: Path) -> dict[str, Path]:
    """Dotted name of every module under a package folder, with its file."""
    found = {}
    for path in sorted(root.rglob("*.py")):
        parts = [root.name, *path.relative_to(root).with_suffix("").parts]
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


def top(module: str) -> str:
    """Name below the package that a module belongs to: fogkit.optics.coil -> optics; the package itself -> ''."""
    return [*module.split("."), ""][1]


@cache
def imports(root: Path) -> tuple[Import, ...]:
    """All imports under a package folder, those inside functions and under TYPE_CHECKING included."""
    return tuple(_imports(root))


def _imports(root: Path) -> Iterator[Import]:
    known = modules(root)
    for source, path in known.items():
        tree = ast.parse(path.read_text(encoding="utf-8"), str(path))
        typing_only = _under_type_checking(tree)
        for node in ast.walk(tree):
            place = f"{path.relative_to(root.parent)}:{getattr(node, 'lineno', 0)}"
            if isinstance(node, ast.Import):
                yield from (Import(source, alias.name, place, node in typing_only) for alias in node.names)
            elif isinstance(node, ast.ImportFrom):
                base = _absolute(node, source, path)
                for alias in node.names:
                    inner = f"{base}.{alias.name}"
                    if inner != f"{root.name}.__version__":  # the one name that the package itself may give
                        yield Import(source, inner if inner in known else base, place, node in typing_only)


def _under_type_checking(tree: ast.Module) -> set[ast.AST]:
    """Nodes in the body of an ``if TYPE_CHECKING:``, which never runs."""
    blocks = (node for node in ast.walk(tree) if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test))
    return {inner for block in blocks for statement in block.body for inner in ast.walk(statement)}


def _absolute(node: ast.ImportFrom, source: str, path: Path) -> str:
    """Dotted name of the module after ``from``, relative imports resolved."""
    if node.level == 0:
        return node.module or ""
    folder = source.split(".") if path.name == "__init__.py" else source.split(".")[:-1]
    return ".".join([*folder[: len(folder) - node.level + 1], *([node.module] if node.module else [])])


def unplaced(root: Path) -> list[str]:
    names = {top(module) for module in modules(root)} - {""}
    return [
        f"{root.name}.{name} has no place in the layers: add it to LAYERS in tests/test_architecture.py, after all "
        "that it imports and before all that imports it"
        for name in sorted(names - set(LAYERS))
    ]


def backward_imports(root: Path) -> list[str]:
    found = []
    for entry in imports(root):
        source, target = top(entry.source), top(entry.target)
        if entry.package != root.name or source not in LAYERS:
            continue  # foreign; or the package itself, which may gather anything; or reported by `unplaced`
        if target == "":
            found.append(f"{entry.place}: imports a name from the package itself; import it from where it is defined")
        elif target != source and target in LAYERS and LAYERS.index(target) > LAYERS.index(source):
            found.append(
                f"{entry.place}: {entry.source} imports {entry.target}, but {target} stands above {source}; move what "
                f"both need down, or what {source} needs of {target} into an argument"
            )
    return found


def kernel_imports(root: Path) -> list[str]:
    allowed = (*KERNEL_IMPORTS, f"{root.name}.constants")
    return [
        f"{entry.place}: kernels take and return plain arrays, so they import only {', '.join(allowed)} and other "
        f"_kernels, not {entry.target}"
        for entry in imports(root)
        if entry.source.endswith("_kernels")
        and entry.package not in KERNEL_IMPORTS
        and entry.target != f"{root.name}.constants"
        and not (entry.package == root.name and entry.target.endswith("_kernels"))
    ]


def drawing(root: Path) -> list[str]:
    return [
        f"{entry.place}: matplotlib is imported only in plotting; return the data and draw it there"
        for entry in imports(root)
        if entry.package == "matplotlib" and top(entry.source) != "plotting"
    ]


def outward_imports(root: Path) -> list[str]:
    return [
        f"{entry.place}: the package must work without {entry.package}, so it may not import {entry.target}"
        for entry in imports(root)
        if entry.package in OUTSIDE
    ]


def cycles(root: Path) -> list[str]:
    graph: dict[str, set[str]] = {module: set() for module in modules(root)}
    for entry in imports(root):
        if entry.target in graph and not entry.typing_only:  # two modules may name each other's types
            graph[entry.source].add(entry.target)
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return ["import cycle: " + " <- ".join(error.args[1]) + "; move what both ends need into a third module"]
    return []


def undocumented(root: Path) -> list[str]:
    found = []
    for module, path in modules(root).items():
        for name, node in _public(ast.parse(path.read_text(encoding="utf-8"))):
            if not ast.get_docstring(node):
                found.append(f"{path.relative_to(root.parent)}:{node.lineno}: {module}.{name} needs a docstring")
    return found


def _public(
    tree: ast.Module | ast.ClassDef, prefix: str = ""
) -> Iterator[tuple[str, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef]]:
    """Public functions and classes of a module, and the public methods of those classes."""
    for node in tree.body:
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef) and not node.name.startswith("_"):
            yield prefix + node.name, node
            if isinstance(node, ast.ClassDef):
                yield from _public(node, f"{prefix}{node.name}.")


def loaded_by_import(root: Path) -> list[str]:
    code = f"import sys, {root.name}; print(*sorted({set(HEAVY)!r} & set(sys.modules)))"
    path = os.pathsep.join(filter(None, [str(root.parent), os.environ.get("PYTHONPATH")]))
    environment = {**os.environ, "PYTHONPATH": path}
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, env=environment)
    if run.returncode:
        return [f"`import {root.name}` fails: {run.stderr.strip().splitlines()[-1]}"]
    return [
        f"`import {root.name}` loads {name}: import it where it is used, or leave that module out of __init__.py"
        for name in run.stdout.split()
    ]


@pytest.mark.parametrize(
    "rule",
    [unplaced, backward_imports, kernel_imports, drawing, outward_imports, cycles, undocumented, loaded_by_import],
    ids=lambda rule: rule.__name__,
)
def test_fogkit_keeps(rule):
    violations = rule(SOURCE)
    assert not violations, "\n" + "\n".join(violations)


def test_the_source_is_read():
    # Guards every rule above against passing because it looked at nothing.
    assert {"fogkit", "fogkit.constants", "fogkit.earth"} <= set(modules(SOURCE))
    assert Import("fogkit.units", "fogkit.constants", "") in {
        Import(entry.source, entry.target, "") for entry in imports(SOURCE)
    }


def tree(root: Path, files: dict[str, str]) -> Path:
    """Package `fogkit` under a folder, from its files and their text."""
    for name, text in {"__init__.py": "", **files}.items():
        path = root / "fogkit" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return root / "fogkit"


GOOD = {
    "__init__.py": "from .optics import coil\n__version__ = '1'\n",
    "constants.py": "import math\n",
    "earth.py": "import numpy as np\nfrom fogkit.constants import EARTH_RATE\nfrom .constants import GM\n",
    "optics/__init__.py": "from .coil import Coil\n",
    "optics/_kernels.py": "import math\nimport numba\nfrom numpy import sin\nfrom fogkit import constants\n",
    "optics/coil.py": "from fogkit.optics import _kernels\nclass Coil:\n    'A coil.'\n    def __len__(self): ...\n",
    "imu/__init__.py": "",
    "imu/_kernels.py": "from fogkit.optics import _kernels\nfrom ..optics._kernels import sin\n",
    "plotting.py": "import matplotlib.pyplot as plt\nimport fogkit.imu\ndef _helper(): ...\n",
    "cli.py": "from fogkit import __version__\n",
    "stand/plans.py": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from fogkit.stand.table import Table\n",
    "stand/table.py": "from fogkit.stand import plans\nclass Table:\n    'A table.'\n",
}


@pytest.mark.parametrize(
    "rule", [unplaced, backward_imports, kernel_imports, drawing, outward_imports, cycles, undocumented]
)
def test_rule_accepts_a_good_tree(rule, tmp_path):
    assert rule(tree(tmp_path, GOOD)) == []


@pytest.mark.parametrize(
    ("rule", "files", "words"),
    [
        (unplaced, {"gadgets.py": ""}, ["fogkit.gadgets", "LAYERS"]),
        (unplaced, {"gadgets/deep/inner.py": ""}, ["fogkit.gadgets", "LAYERS"]),
        (backward_imports, {"earth.py": "import fogkit.optics.coil\n"}, ["earth.py:1", "optics stands above earth"]),
        (backward_imports, {"earth.py": "\nfrom .optics import coil\n"}, ["earth.py:2", "fogkit.optics.coil"]),
        (backward_imports, {"earth.py": "from fogkit import optics\n"}, ["imports fogkit.optics,"]),
        (backward_imports, {"optics/coil.py": "from ..imu import x\n"}, ["fogkit.optics.coil imports fogkit.imu,"]),
        (backward_imports, {"optics/__init__.py": "from ..imu import x\n"}, ["fogkit.optics imports fogkit.imu,"]),
        (backward_imports, {"earth.py": "def f():\n    from fogkit import imu\n"}, ["earth.py:2"]),
        (backward_imports, {"constants.py": "from fogkit.units import DEG\n", "units.py": ""}, ["units stands above"]),
        (backward_imports, {"earth.py": "from fogkit import EARTH_RATE\n"}, ["where it is defined"]),
        (backward_imports, {"earth.py": "import fogkit\n"}, ["where it is defined"]),
        (
            backward_imports,
            {"earth.py": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from fogkit.imu import Imu\n"},
            ["earth.py:3"],
        ),
        (kernel_imports, {"optics/_kernels.py": "import scipy.signal\n"}, ["_kernels.py:1", "not scipy.signal"]),
        (kernel_imports, {"optics/_kernels.py": "from fogkit import checks\n", "checks.py": ""}, ["not fogkit.checks"]),
        (kernel_imports, {"optics/_kernels.py": "from .coil import Coil\n"}, ["not fogkit.optics.coil"]),
        (kernel_imports, {"imu/_kernels.py": "from scipy import _kernels\n"}, ["not scipy"]),
        (kernel_imports, {"imu/_loop_kernels.py": "import pandas\n"}, ["_loop_kernels.py:1", "not pandas"]),
        (drawing, {"imu/__init__.py": "def f():\n    from matplotlib import pyplot\n"}, ["__init__.py:2", "plotting"]),
        (outward_imports, {"cli.py": "from tests.reference import table\n"}, ["cli.py:1", "tests.reference"]),
        (outward_imports, {"cli.py": "import book\n"}, ["may not import book"]),
        (cycles, {"imu/a.py": "from . import b\n", "imu/b.py": "from fogkit.imu.a import x\n"}, ["fogkit.imu.a <- "]),
        (cycles, {"stand/plans.py": "def f():\n    from . import table\n"}, ["fogkit.stand.table <- "]),
        (cycles, {"earth.py": "import fogkit.earth\n"}, ["fogkit.earth <- fogkit.earth"]),
        (cycles, {"optics/coil.py": "from fogkit.optics import Coil\n"}, ["fogkit.optics.coil", "third module"]),
        (undocumented, {"earth.py": "def f(): ...\n"}, ["earth.py:1", "fogkit.earth.f"]),
        (undocumented, {"earth.py": "class A:\n    'Doc.'\n    def f(self): ...\n"}, ["fogkit.earth.A.f"]),
        (undocumented, {"earth.py": "class A:\n    x: int\n"}, ["fogkit.earth.A "]),
    ],
)
def test_rule_reports_a_bad_tree(rule, files, words, tmp_path):
    violations = rule(tree(tmp_path, {**GOOD, **files}))
    assert len(violations) == 1
    assert all(word in violations[0] for word in words), violations[0]


def test_loading_is_reported(tmp_path):
    (tmp_path / "pandas.py").touch()  # stands in for the real one, which is slow
    heavy = tree(tmp_path, {"__init__.py": "import fogkit.io\n", "io.py": "import pandas\n"})
    (violation,) = loaded_by_import(heavy)
    assert "loads pandas" in violation


def test_a_broken_import_is_reported(tmp_path):
    (violation,) = loaded_by_import(tree(tmp_path, {"__init__.py": "import fogkit.nothing\n"}))
    assert "ModuleNotFoundError" in violation
