"""A search of settings whose trials are tasks of Ray."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from typing import Any

import pyarrow

from .._fingerpost import Search, front
from ._drives import RecordedDrive, SimulatedDrive
from ._folder import FleetError, ResultFolder, write
from ._run import Fleet, check

#: What is to be small.
OBJECTIVES = ("missed", "false", "error_p95_m")


def tune(
    drives: Sequence[SimulatedDrive | RecordedDrive],
    out: str | os.PathLike[str],
    *,
    keys: Mapping[str, tuple[float, float]],
    trials: int = 40,
    population: int = 10,
    seed: int = 1,
    held_out: Sequence[SimulatedDrive | RecordedDrive] = (),
    config: str | None = None,
    program: str | os.PathLike[str] = "fingerpost",
    cpus: int = 1,
    retries: int = 3,
) -> pyarrow.Table:
    """Searches the settings that no others beat in everything, by NSGA-II; every drive of every trial is a task of Ray.

    ``keys`` are numbers of the configuration with their ranges, as in ``{"track.detect_present": (0.6, 0.9)}``. The first trial is today's
    settings, ``config`` or the defaults; ``population`` trials are done at a time. The drives need truth, and no controller.

    Gives a row for each trial: its settings; ``missed``, the share of features; ``false``, false detections a drive; ``error_p95_m``, the mean
    over drives of the 95th percentile of a feature's place, metres; ``front``, whether no other trial beats it; and for the front and the first
    trial ``held_out_missed`` and so on, of drives that the search never saw. That is in ``out/trials.parquet`` too, and ``out/TRIAL.toml`` is the
    configuration of each trial of the front. The same call goes on with a search that was ended.

    Raises FleetError where the first trial fails on a drive, or a drive has no truth, and ConfigError where a key cannot be searched.
    """
    check([*drives, *held_out])
    search = Search([(key, *limits) for key, limits in keys.items()], config=config, population=population, seed=seed)
    fleet = Fleet.joined(program, cpus, retries)
    with ResultFolder.opened(out) as folder:

        def measured(texts: Sequence[str], on: Sequence[SimulatedDrive | RecordedDrive]) -> list[list[dict[str, Any]]]:
            rows = iter(fleet.rows([fleet.job(drive, text) for text in texts for drive in on], folder))
            return [[next(rows) for _ in on] for _ in texts]

        done: list[dict[str, Any]] = []
        configs: list[str] = []
        while len(done) < trials and (asked := search.ask()):
            generation = asked[: trials - len(done)]
            texts = [text for _, text in generation]
            for (settings, _), rows in zip(generation, measured(texts, drives), strict=True):
                done.append({"trial": len(done), **settings, **_scores(rows, is_first=not done)})
            configs += texts
            if len(generation) < len(asked):
                break
            search.tell([_objectives(trial) for trial in done[-len(asked) :]])

        best = front([_objectives(trial) for trial in done])
        for trial in done:
            trial["front"] = trial["trial"] in best
        if held_out:
            shown = sorted({0, *best})
            for number, rows in zip(shown, measured([configs[number] for number in shown], held_out), strict=True):
                done[number] |= {f"held_out_{name}": value for name, value in _scores(rows, is_first=False).items()}
        for number in best:
            write(folder.path / f"{number}.toml", configs[number].encode())
        return folder.write_table("trials.parquet", done)


def _scores(rows: Sequence[Mapping[str, Any]], *, is_first: bool) -> dict[str, Any]:
    """What came of a trial on its drives; nothing where the program refused its settings on one."""
    error = next((row["error"] for row in rows if row["error"] is not None), None)
    if any(row["program"] is None for row in rows):
        raise FleetError(f"a drive was not run, which says nothing of the settings: {error}\nThe same call goes on with it")
    if error is not None and is_first:
        raise FleetError(f"the settings that the search begins with fail on a drive: {error}")
    if error is not None:
        return {**dict.fromkeys(OBJECTIVES), "error": error}
    if any(row.get("features_total") is None for row in rows):
        raise FleetError("a drive has no truth to measure trials by; give truth=, and no controller")
    features = sum(row["features_total"] for row in rows)
    errors = [row["position_error_m"]["p95"] for row in rows if row["position_error_m"] is not None]
    return {
        "missed": 1 - sum(row["features_detected"] for row in rows) / features if features else None,
        "false": sum(row["false_detections"] for row in rows) / len(rows),
        "error_p95_m": sum(errors) / len(errors) if errors else None,
        "error": None,
    }


def _objectives(trial: Mapping[str, Any]) -> list[float]:
    return [math.inf if trial[name] is None else trial[name] for name in OBJECTIVES]
