"""The three tables: run time against error, cost against size, run time against what is asked."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from benchmarks.jobs import Job
from benchmarks.measure import Measuring
from benchmarks.stats import SEEN_BYTES, exponent

Row = dict[str, Any]
TOLERANCES = (1.0, 0.1, 1e-2)  # [m]
QUESTIONS = ("one curve", "all curves", "one unit", "units", "one picture")


def decades(size: float, count: int) -> list[float]:
    """Return so many sizes up to the largest, each half a decade above the one before.

    Examples
    --------
    >>> decades(2e6, 3)
    [200000.0, 632000.0, 2000000.0]
    """
    return [float(f"{size / 10 ** (0.5 * k):.3g}") for k in range(count)][::-1]


def error_jobs(run: Measuring, sizes: Sequence[float]) -> list[Job]:
    """Return what is measured for run time against error, for curves and for units.

    Parameters
    ----------
    run : Measuring
    sizes : sequence of float
        Numbers of triangles of the scene whose true curve and volumes are known.

    Returns
    -------
    list of Job
    """
    jobs = [run.job("curve", "waves", size, method=m) for m in ("auto", "tree", "voxels")
            for size in sizes]  # fmt: skip
    jobs += [run.job("curve", "waves", size, peer) for peer in ("compas_cgal", "vtk")
             for size in sizes]  # fmt: skip
    few = [size for size in sizes if size <= 1e6]
    jobs += [run.job("units", "waves", size, peer) for peer in ("", "manifold3d") for size in few]
    return jobs + [run.job("units", "waves", few[-1], tolerance=t) for t in TOLERANCES if few]


def error_table(rows: list[Row]) -> dict[str, Any]:
    """
    Return run time against error.

    Parameters
    ----------
    rows : list of dict
        Of `error_jobs`, measured.

    Returns
    -------
    dict
        ``"rows"``: with ``"route"``, ``"error_m"`` (Hausdorff distance) or ``"volume_error"``
        (relative); ``"notes"``.
    """
    for row in rows:
        row["route"] = route_name(row)
        answer = row.get("answer", {})
        if "strays" in answer:
            row["error_m"] = max(answer["strays"], answer["misses"])
        if "volume_error" in answer:
            row["volume_error"] = answer["volume_error"]
    return {"rows": rows, "notes": []}


def route_name(row: Row) -> str:
    """Return who went which way.

    Examples
    --------
    >>> route_name({"who": "geosurf", "options": {"method": "voxels"}})
    'geosurf, voxels'
    """
    options = row["options"]
    if "tolerance" in options:
        return f"geosurf, tolerance on {row['size']:.0e}".replace("e+0", "e")
    method = options.get("method", "auto")
    return row["who"] if method == "auto" else f"{row['who']}, {method}"


def growth_jobs(run: Measuring, sizes: Sequence[float]) -> list[Job]:
    """Return what is measured for run time and memory against size; see `error_jobs`."""
    calls = (
        ("curve", ""), ("curve, kept search", ""), ("split", ""),
        ("curve", "compas_cgal"), ("curve", "vtk"), ("split", "loop_cgal"),
        ("curve", "trueform"), ("split", "trueform"),
    )  # fmt: skip
    return [run.job(task, "S1", size, peer) for task, peer in calls for size in sizes]


def growth_table(rows: list[Row]) -> dict[str, Any]:
    """
    Return run time and memory against the number of triangles.

    Parameters
    ----------
    rows : list of dict
        Of `growth_jobs`, measured.

    Returns
    -------
    dict
        ``"rows"``, and ``"exponents"``: for each series, that of its time and of its memory over
        the larger half of the sizes.
    """
    for row in rows:
        row["series"] = f"{row['who']}: {row['task']}"
        if not row["error"]:
            row["times_input"] = row["extra_bytes"] / row["input_bytes"]
    exponents = {}
    for series in dict.fromkeys(row["series"] for row in rows):
        fits = _fits([row for row in rows if row["series"] == series and not row["error"]])
        if fits:
            exponents[series] = fits
    return {"rows": rows, "exponents": exponents, "notes": []}


def _fits(rows: list[Row]) -> dict[str, float]:
    """Exponents over the larger half of the sizes, at least two; memory where it was seen."""
    large = rows[-max(2, (len(rows) + 1) // 2) :]
    found = {}
    for key, least in (("seconds", 0.0), ("extra_bytes", SEEN_BYTES)):
        seen = [row for row in large if row[key] > least]
        if len({row["triangles"] for row in seen}) > 1:
            found[key] = exponent([row["triangles"] for row in seen], [row[key] for row in seen])
    return found


def question_jobs(run: Measuring, sizes: Sequence[float]) -> list[Job]:
    """Return what is measured for run time against what is asked; see `error_jobs`."""
    return [run.job(task, "block", size) for size in sizes for task in QUESTIONS]


def question_table(rows: list[Row]) -> dict[str, Any]:
    """
    Return run time against what is asked of a fresh `Scene`.

    Parameters
    ----------
    rows : list of dict
        Of `question_jobs`, measured.

    Returns
    -------
    dict
        ``"rows"``, with ``"asked"``.
    """
    for row in rows:
        row["asked"] = {"units": "all units"}.get(row["task"], row["task"])
    return {"rows": rows, "notes": []}


JOBS = {"error": error_jobs, "growth": growth_jobs, "questions": question_jobs}
LAYOUT = {"error": error_table, "growth": growth_table, "questions": question_table}
