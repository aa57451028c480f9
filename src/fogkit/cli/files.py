"""Files that are whole or not there, and which file it was that was read."""

import hashlib
import os
from pathlib import Path
from typing import Any

from fogkit.io.errors import RecordingError


def write_whole(path: Path, text: str) -> None:
    """Write a text under another name beside its place and move it there: a reader sees all of it or nothing.

    Parameters
    ----------
    path : Path
        The file; its folder is made if need be.
    text : str
        What it will hold, as UTF-8.

    Raises
    ------
    RecordingError
        If it cannot be written. What stood there before is then untouched, as after an interrupt.
    """
    partial = path.with_name(f".{path.name}.{os.getpid()}.partial")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            with partial.open("w", encoding="utf-8", newline="\n") as stream:
                stream.write(text)
                stream.flush()
                os.fsync(stream.fileno())
            os.replace(partial, path)
        finally:
            partial.unlink(missing_ok=True)
    except OSError as error:
        raise RecordingError(f"{path} cannot be written: {error.strerror or error}") from None


def read_text(path: Path) -> str:
    """Text of a file; `RecordingError` of one sentence if it cannot be read."""
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise RecordingError(f"{path} cannot be read: {error.strerror or error}") from None
    except UnicodeDecodeError:
        raise RecordingError(f"{path} is no text in UTF-8") from None


def described(path: Path) -> dict[str, Any]:
    """Name, SHA-256 and size of a file that was read: which one a result is of."""
    digest = hashlib.sha256()
    try:
        with path.open("rb") as stream:
            while part := stream.read(1 << 20):
                digest.update(part)
        return {"name": path.name, "sha256": digest.hexdigest(), "bytes": path.stat().st_size}
    except OSError as error:
        raise RecordingError(f"{path} cannot be read: {error.strerror or error}") from None


def versions() -> dict[str, str]:
    """Versions of the package, of Python, and of the libraries that the numbers depend on."""
    import platform
    from importlib.metadata import version

    from fogkit import __version__

    return {"fogkit": __version__, "python": platform.python_version()} | {
        name: version(name) for name in ("numpy", "scipy", "pandas", "numba", "pyarrow")
    }
