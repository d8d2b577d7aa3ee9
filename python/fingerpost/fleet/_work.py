"""What a worker does: the program on one drive."""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import json
import os
import pathlib
import socket
import subprocess
import tempfile
from typing import Any

from ._drives import Drive
from ._folder import FleetError

#: Lines of what the program says last that tell why it failed.
LAST_LINES = 3


@dataclasses.dataclass(frozen=True)
class Job:
    """A drive with all that its result depends on, and how it is done."""

    drive: Drive
    config: str | None
    keep: tuple[str, ...]
    version: str
    program: str
    threads: int

    @functools.cached_property
    def id(self) -> str:
        """The same for what gives the same result."""
        depends_on = [type(self.drive).__name__, vars(self.drive), self.config, self.keep, self.version]
        return hashlib.sha256(json.dumps(depends_on, sort_keys=True, default=str).encode()).hexdigest()[:20]


@dataclasses.dataclass(frozen=True)
class Outcome:
    """What came of a drive: its result, files that are kept of it, or why there are none, and whether the program came to its end."""

    result: dict[str, Any] = dataclasses.field(default_factory=dict)
    files: dict[str, bytes] = dataclasses.field(default_factory=dict)
    error: str | None = None
    has_run: bool = True


def version(program: str) -> str:
    """Which program a machine has."""
    try:
        return subprocess.run([program, "--version"], check=True, capture_output=True, text=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError) as cause:
        raise FleetError(
            f"{socket.gethostname()} cannot run the program {program} ({cause}); install it there, or name another with program="
        ) from cause


def work(job: Job) -> Outcome:
    """Runs the program on a drive, in a folder that is removed afterwards."""
    if (own := version(job.program)) != job.version:
        raise FleetError(f"{socket.gethostname()} has {own} and the fleet began with {job.version}; install the same on every machine")
    with tempfile.TemporaryDirectory(prefix="fingerpost-fleet-") as name:
        folder = pathlib.Path(name) / "out"
        config = None
        if job.config is not None:
            config = os.path.join(name, "fingerpost.toml")
            pathlib.Path(config).write_text(job.config, "utf-8")
        command = job.drive.command(str(folder), config=config, threads=job.threads, keep=job.keep)
        # A worker that is killed takes the program with it, so that it does not go on beside its next try.
        tethered = [job.program, "tether", str(os.getpid()), job.program, *command]
        done = subprocess.run(tethered, stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace", check=False)
        result = job.drive.result(folder)
        if done.returncode != 0:
            said = [line for line in done.stderr.splitlines() if line.strip()][-LAST_LINES:]
            return Outcome(result, error="\n".join(said) or f"the program ended with {done.returncode} and said nothing")
        missing = [name for name in job.keep if not (folder / name).is_file()]
        if missing:
            return Outcome(result, error=f"there is no file {', '.join(missing)} to keep; see what the program writes, and correct keep=")
        return Outcome(result, {name: (folder / name).read_bytes() for name in job.keep})
