"""The source files of the kernels: those of a folder and its rooms, except `compile`."""

from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
MACHINERY = "compile"


def kernel_files(folder: Path) -> list[Path]:
    """
    Return the kernel files of a folder and its rooms, in order; no two have one name.

    Parameters
    ----------
    folder : pathlib.Path

    Returns
    -------
    list of pathlib.Path

    Examples
    --------
    >>> [path.name for path in kernel_files(ROOT) if path.parent.name == "search"][:2]
    ['rays.py', 'separation.py']
    """
    # A flat folder, as in tests, or rooms.
    found = [*folder.glob("*.py"), *folder.glob("*/*.py")]
    return sorted(
        path
        for path in found
        if not path.name.startswith("_") and MACHINERY != path.parent.relative_to(folder).name
    )


def module_of(file: Path) -> str:
    """Return the name of the module in a kernel file of geosurf."""
    return ".".join(["geosurf.kernels", *file.relative_to(ROOT).with_suffix("").parts])


def file_of(module: str) -> Path:
    """Return the kernel file of a module of geosurf."""
    return ROOT.joinpath(*module.split(".")[2:]).with_suffix(".py")
