"""Thousands of drives over a cluster, on Ray.

Drives that are simulated or recorded, each a task of Ray, each with one result::

    from fingerpost import fleet

    drives = [fleet.RecordedDrive(f"/drives/{day}", camera=f"/drives/{day}/camera.toml") for day in ("monday", "tuesday")]
    table = fleet.run(drives, "out")

A drive whose worker dies is tried again by Ray, on another machine if need be. Every result is a file of its own as soon as it is there, so
that the same call after a kill of the whole job goes on with the drives that are missing. In the end all are in ``results.parquet``.

The work is done by the program ``fingerpost``, which must be installed on every machine, in one version, as must be this package with its
extra ``fleet``. Recorded drives and maps must have the same path on every machine; results come back to the caller by themselves.
The cluster is the one that Ray is connected to, or else what ``ray.init()`` finds or starts: the caller's own machine.
"""

try:
    import pyarrow as _pyarrow  # noqa: F401
    import ray as _ray  # noqa: F401
except ImportError as cause:
    raise ImportError(f"fingerpost.fleet needs Ray and pyarrow ({cause}); install them with pip install 'fingerpost[fleet]'") from cause

from ._drives import CONDITIONS, RecordedDrive, SimulatedDrive, campaign_drives
from ._folder import FleetError
from ._run import campaign, run
from ._tune import tune

__all__ = ["CONDITIONS", "FleetError", "RecordedDrive", "SimulatedDrive", "campaign", "campaign_drives", "run", "tune"]
