"""Drives: how the program is asked for one, and what it gives."""

from __future__ import annotations

import dataclasses
import json
import os
import pathlib
from collections.abc import Sequence
from typing import Any, Literal, Protocol

#: What the drives of a campaign are like where nothing else is said, as in ``fingerpost campaign``.
CONDITIONS = ("world", "shadows", "wet", "mixed", "dusk", "dust", "street", "street_shade")


class Drive(Protocol):
    """What a task of the fleet is made of."""

    @property
    def name(self) -> str:
        """What it is called in messages."""

    @property
    def kind(self) -> str:
        """Which results it has; those of two kinds do not share a table."""

    def command(self, folder: str, *, config: str | None, threads: int, keep: Sequence[str]) -> list[str]:
        """The program's arguments, its results to be written into a folder; ``config`` is a file."""

    def result(self, folder: pathlib.Path) -> dict[str, Any]:
        """What the program wrote there; empty where it wrote nothing."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class SimulatedDrive:
    """A drive as ``fingerpost campaign`` draws it: all of it follows from ``seed`` and ``conditions``.

    ``size`` is that of the pictures, width and height in pixels, ``fps`` their number a second; by default the campaign's. ``map`` is an
    OpenStreetMap extract in place of the built-in town. With a ``controller`` the vehicle is driven by the advice, as with
    ``--closed-loop``, and ``fault`` names what goes wrong besides. Its result is that of ``drives`` in campaign.json, or its line of
    closed_loop.jsonl.
    """

    seed: int
    conditions: str = "clear"
    size: tuple[int, int] | None = None
    fps: float | None = None
    map: str | os.PathLike[str] | None = None
    controller: Literal["pure_pursuit", "stanley", "fuzzy"] | None = None
    fault: str | None = None

    def __post_init__(self) -> None:
        _make_absolute(self, "map")

    @property
    def name(self) -> str:
        """What it is called in messages."""
        parts = (self.conditions, f"seed {self.seed}", self.controller, self.fault)
        return ", ".join(part for part in parts if part)

    @property
    def kind(self) -> str:
        """Which results it has."""
        return "campaign" if self.controller is None else "closed loop"

    def command(self, folder: str, *, config: str | None, threads: int, keep: Sequence[str]) -> list[str]:
        """The program's arguments."""
        words = ["campaign", "--drives", "1", "--seed", str(self.seed), "--conditions", self.conditions]
        words += ["--threads", str(threads), "--out", folder]
        if self.size is not None:
            words += ["--size", "{}x{}".format(*self.size)]
        for option, value in (("fps", self.fps), ("map", self.map), ("config", config), ("fault", self.fault)):
            if value is not None:
                words += [f"--{option}", str(value)]
        if self.controller is not None:
            words += ["--closed-loop", "--controllers", self.controller]
        return words

    def result(self, folder: pathlib.Path) -> dict[str, Any]:
        """Its part of what the campaign wrote."""
        if self.controller is None:
            return _first(_read(folder / "campaign.json").get("drives", []))
        path = folder / "closed_loop.jsonl"
        return _first([json.loads(line) for line in path.read_text("utf-8").splitlines()] if path.exists() else [])


@dataclasses.dataclass(frozen=True, kw_only=True)
class RecordedDrive:
    """A drive that ``fingerpost run`` is given: a folder of pictures or a video, its camera and, where there is one, its route.

    ``arguments`` are more of ``fingerpost run``, such as ``("--gps", "/drives/monday/gps.gpx")``, with paths from the root. Its result is what
    summary.json holds. Paths are the same on every machine. A file that is replaced by another is not noticed: choose another folder for
    the results then.
    """

    input: str | os.PathLike[str]
    camera: str | os.PathLike[str]
    route: str | os.PathLike[str] | None = None
    start_m: float | None = None
    truth: str | os.PathLike[str] | None = None
    arguments: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        _make_absolute(self, "input", "camera", "route", "truth")
        object.__setattr__(self, "arguments", tuple(self.arguments))

    @property
    def name(self) -> str:
        """What it is called in messages."""
        return str(self.input)

    @property
    def kind(self) -> str:
        """Which results it has."""
        return "run"

    def command(self, folder: str, *, config: str | None, threads: int, keep: Sequence[str]) -> list[str]:
        """The program's arguments."""
        words = ["run", str(self.input), "--camera", str(self.camera), "--threads", str(threads), "--out", folder]
        for option, value in (("route", self.route), ("start-m", self.start_m), ("truth", self.truth), ("config", config)):
            if value is not None:
                words.append(f"--{option}={value}")
        if "run.mcap" not in keep:
            words.append("--no-recording")
        return [*words, *self.arguments]

    def result(self, folder: pathlib.Path) -> dict[str, Any]:
        """The run in numbers."""
        return _read(folder / "summary.json")


def campaign_drives(
    count: int,
    *,
    seed: int = 1,
    conditions: Sequence[str] = CONDITIONS,
    size: tuple[int, int] | None = None,
    fps: float | None = None,
    map: str | os.PathLike[str] | None = None,
    controllers: Sequence[Literal["pure_pursuit", "stanley", "fuzzy"]] = (),
    fault: str | None = None,
) -> list[SimulatedDrive]:
    """The drives of ``fingerpost campaign --drives count``: seeds count up from ``seed``, conditions are taken in turns.

    With ``controllers`` every one of them drives each, in closed loop.
    """
    return [
        SimulatedDrive(
            seed=seed + number,
            conditions=conditions[number % len(conditions)],
            size=size,
            fps=fps,
            map=map,
            controller=controller,
            fault=fault,
        )
        for number in range(count)
        for controller in (controllers or (None,))
    ]


def _make_absolute(drive: object, *names: str) -> None:
    """Paths of a drive made independent of the folder that a worker runs in; addresses such as rtsp:// stay."""
    for name in names:
        path = getattr(drive, name)
        if path is not None:
            object.__setattr__(drive, name, str(path) if "://" in str(path) else os.path.abspath(path))


def _read(path: pathlib.Path) -> dict[str, Any]:
    return json.loads(path.read_text("utf-8")) if path.exists() else {}


def _first(results: list[dict[str, Any]]) -> dict[str, Any]:
    return results[0] if results else {}
