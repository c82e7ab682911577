"""Whether a timed result is right; a wrong one is marked wherever its time is shown."""

from __future__ import annotations

from typing import Any

from benchmarks.jobs import Job, Result

LENGTH = 1e-6  # relative; float32 at UTM coordinates is off by 1e-4, exact packages by 1e-12
AREA = 1e-9
VOLUME = 1e-12
UNITS = {"block": 6, "waves": 4}
TIPS = {"torn": 12, "drogon field": 40}


def judge(result: Result, truth: dict[str, Any] | None = None) -> list[str]:
    """
    Return what is wrong with a result, in words; nothing for a right one.

    Parameters
    ----------
    result : Result
    truth : dict, optional
        What is known of the right answer: "length" [m] and number of "segments" of the curves,
        number of "units", of "tips".

    Returns
    -------
    list of str

    Examples
    --------
    >>> found = Result(Job("curve", "S1", 2e4), [0.1], answer={"length": 90.0, "segments": 9})
    >>> judge(found, {"length": 100.0, "segments": 10})
    ['length 90.000 m, true 100.000 m', '9 segments, true 10']
    """
    if result.error:
        return []
    answer, truth, wrong = result.answer, truth or {}, []
    if "length" in truth and "length" in answer:
        length, true = answer["length"], truth["length"]
        if abs(length - true) > LENGTH * true:
            wrong.append(f"length {length:.3f} m, true {true:.3f} m")
    for key in ("segments", "units", "tips"):
        if key in truth and key in answer and answer[key] != truth[key]:
            wrong.append(f"{answer[key]} {key}, true {truth[key]}")
    if answer.get("area_error", 0.0) > AREA:
        wrong.append(f"areas off by {answer['area_error']:.1e}")
    if answer.get("closed") is False:
        wrong.append("a unit is open")
    for key, what in (("box_error", "the box"), ("zone_error", "the zones between the grids")):
        if answer.get(key, 0.0) > VOLUME:
            wrong.append(f"volumes off {what} by {answer[key]:.1e}")
    return wrong


def known_truth(name: str, size: float) -> Job | dict[str, Any]:
    """Return what is right for a scene: numbers, or the job that finds them by plain numpy.

    Parameters
    ----------
    name : str
        Of the scene.
    size : float

    Returns
    -------
    Job or dict

    Examples
    --------
    >>> known_truth("parallel chords", 500)["segments"]
    500
    """
    if name == "parallel chords":
        return {"segments": round(size)}
    if name in TIPS:
        return {"tips": TIPS[name]}
    if name in ("drogon", "crossing chords", "five horizons"):
        return {}
    scene = "S1" if name == "S1 shuffled" else name
    return Job("truth", scene, size, repeats=1, budget=0.0, warm=False)
