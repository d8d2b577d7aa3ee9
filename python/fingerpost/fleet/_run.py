"""Drives as tasks of Ray."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterable, Sequence
from typing import Any, Literal

import pyarrow
import ray

from . import _work
from ._drives import CONDITIONS, Drive, RecordedDrive, SimulatedDrive, campaign_drives
from ._folder import FleetError, ResultFolder
from ._work import Job, Outcome


@dataclasses.dataclass(frozen=True)
class Fleet:
    """How tasks are done."""

    program: str
    cpus: int
    retries: int
    version: str

    @staticmethod
    def joined(program: str | os.PathLike[str], cpus: int, retries: int) -> Fleet:
        """The fleet of the cluster that Ray is connected to or else finds or starts."""
        if not ray.is_initialized():
            ray.init()
        program = os.path.abspath(program) if os.sep in str(program) else str(program)
        ask = ray.remote(_work.version).options(num_cpus=cpus, max_retries=retries, name="fingerpost --version")
        try:
            return Fleet(program, cpus, retries, ray.get(ask.remote(program)))
        except ray.exceptions.RayTaskError as raised:
            raise raised.cause from raised

    def job(self, drive: Drive, config: str | None, keep: Sequence[str] = ()) -> Job:
        """A drive as a job of this fleet."""
        return Job(drive, config, tuple(keep), self.version, self.program, self.cpus)

    def rows(self, jobs: Iterable[Job], folder: ResultFolder) -> list[dict[str, Any]]:
        """Does the jobs that are not done yet; the rows of all, in their order. Each is in the folder as soon as it is there."""
        jobs = list(jobs)
        rows = {job.id: row for job in jobs if (row := folder.done(job.id)) is not None}
        task = ray.remote(_work.work)
        missing = {job.id: job for job in jobs if job.id not in rows}
        pending = {
            task.options(num_cpus=self.cpus, max_retries=self.retries, name=f"fingerpost: {job.drive.name}").remote(job): job
            for job in missing.values()
        }
        try:
            while pending:
                ready, _ = ray.wait(list(pending), num_returns=1)
                for reference in ready:
                    outcome, job = self._outcome(reference), pending.pop(reference)
                    rows[job.id] = _row(job, outcome)
                    folder.add(job.id, rows[job.id], outcome.files)
        finally:
            # Only where an exception ends this early.
            for reference in pending:
                ray.cancel(reference, force=True)
        return [rows[job.id] for job in jobs]

    def _outcome(self, reference: ray.ObjectRef[Outcome]) -> Outcome:
        try:
            outcome: Outcome = ray.get(reference)
            return outcome
        except ray.exceptions.RayTaskError as raised:
            if isinstance(raised.cause, FleetError):
                raise raised.cause from raised
            return Outcome(error=f"its worker failed: {raised.cause}; put that right, then call again", has_run=False)
        except ray.exceptions.RayError as cause:
            error = f"its worker died, and that of {self.retries} more tries ({cause}); see Ray's logs for why, then call again"
            return Outcome(error=error, has_run=False)


def _row(job: Job, outcome: Outcome) -> dict[str, Any]:
    """What came of a drive: what it was made of, what the program wrote, which program that was, and why it failed."""
    program = job.version if outcome.has_run else None
    return {"id": job.id, **vars(job.drive), **outcome.result, "program": program, "error": outcome.error}


def check(drives: Sequence[Drive]) -> None:
    """Whether these drives can be done together."""
    kinds = sorted({drive.kind for drive in drives})
    if not kinds:
        raise FleetError("there are no drives; give one at the least")
    if len(kinds) > 1:
        raise FleetError(f"drives of {' and '.join(kinds)} have different results; give those of one kind, and the others a folder of their own")


def run(
    drives: Sequence[SimulatedDrive | RecordedDrive],
    out: str | os.PathLike[str],
    *,
    config: str | None = None,
    keep: Sequence[str] = (),
    program: str | os.PathLike[str] = "fingerpost",
    cpus: int = 1,
    retries: int = 3,
) -> pyarrow.Table:
    """Runs the method on drives, each a task of Ray, and gives a row for each, in their order.

    ``out`` is a folder of this machine: ``drives/`` has a file for every drive that is done, ``results.parquet`` all of them in the end. The same
    call goes on with those that are missing or failed. A row has what the drive was made of, what the program wrote of it, ``program``, its
    version, null where no try of it came to an end, and ``error``, null where all went well.

    ``config`` is the text of a fingerpost.toml. ``keep`` names files of the program's folder that are brought to ``out/files/ID/``, such as
    ``frames.jsonl`` and ``report.html`` of recorded drives. ``cpus`` are processor cores a drive, ``retries`` how often Ray tries a drive again
    whose worker died.

    Raises FleetError where drives failed, when all are done and the table is written, or where a machine has no such program.
    """
    check(drives)
    fleet = Fleet.joined(program, cpus, retries)
    with ResultFolder.opened(out) as folder:
        rows = fleet.rows([fleet.job(drive, config, keep) for drive in drives], folder)
        table = folder.write_table("results.parquet", rows)
    failed = [(drive, row["error"]) for drive, row in zip(drives, rows, strict=True) if row["error"] is not None]
    if failed:
        drive, error = failed[0]
        raise FleetError(
            f"{len(failed)} of {len(rows)} drives failed, the first of them {drive.name}: {error}\nThe results of the others are in {out}; the "
            "same call tries the failed ones again"
        )
    return table


def campaign(
    count: int,
    out: str | os.PathLike[str],
    *,
    seed: int = 1,
    conditions: Sequence[str] = CONDITIONS,
    size: tuple[int, int] | None = None,
    fps: float | None = None,
    map: str | os.PathLike[str] | None = None,
    controllers: Sequence[Literal["pure_pursuit", "stanley", "fuzzy"]] = (),
    fault: str | None = None,
    config: str | None = None,
    program: str | os.PathLike[str] = "fingerpost",
    cpus: int = 1,
    retries: int = 3,
) -> pyarrow.Table:
    """The drives of ``fingerpost campaign --drives count`` over the cluster, as ``run`` does them: the same drives, the same numbers.

    With ``controllers`` the drives of ``--closed-loop``. Raises FleetError as ``run`` does.
    """
    drives = campaign_drives(
        count, seed=seed, conditions=conditions, size=size, fps=fps, map=map, controllers=controllers, fault=fault
    )
    return run(drives, out, config=config, program=program, cpus=cpus, retries=retries)
