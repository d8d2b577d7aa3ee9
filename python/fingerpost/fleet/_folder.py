"""The folder of a fleet's results: a file for each drive that is done, and all of them as Parquet."""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import pathlib
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import pyarrow
import pyarrow.parquet

from .._fingerpost import FingerpostError


class FleetError(FingerpostError):
    """Drives failed, or the fleet cannot work; results that are there stay."""


class ResultFolder:
    """``drives/ID.json`` is there when the drive is done, and whole; ``files/ID/`` has what was kept of it."""

    def __init__(self, path: pathlib.Path) -> None:
        self.path = path
        (path / "drives").mkdir(parents=True, exist_ok=True)

    @staticmethod
    @contextlib.contextmanager
    def opened(path: str | os.PathLike[str]) -> Iterator[ResultFolder]:
        """The folder, made where it is missing, for this caller alone."""
        folder = ResultFolder(pathlib.Path(path))
        with open(folder.path / ".lock", "w", encoding="utf-8") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError as cause:
                raise FleetError(f"{path} is being written by another fleet ({cause}); wait for it or choose another folder") from cause
            yield folder

    def done(self, id: str) -> dict[str, Any] | None:
        """The row of a drive that is done and did not fail."""
        path = self._row(id)
        if not path.exists():
            return None
        row = json.loads(path.read_text("utf-8"))
        return row if row["error"] is None else None

    def add(self, id: str, row: Mapping[str, Any], files: Mapping[str, bytes]) -> None:
        """Writes what came of a drive; the row last, so that whoever sees it sees all."""
        for name, content in files.items():
            write(self.path / "files" / id / name, content)
        write(self._row(id), json.dumps(row).encode())

    def write_table(self, name: str, rows: Iterable[Mapping[str, Any]]) -> pyarrow.Table:
        """Rows as a Parquet file; what one of them lacks is null in it."""
        rows = list(rows)
        columns = dict.fromkeys(column for row in rows for column in row)
        table = pyarrow.table({column: pyarrow.array([row.get(column) for row in rows]) for column in columns})
        sink = pyarrow.BufferOutputStream()
        pyarrow.parquet.write_table(_storable(table), sink)
        write(self.path / name, sink.getvalue().to_pybytes())
        return table

    def _row(self, id: str) -> pathlib.Path:
        return self.path / "drives" / f"{id}.json"


def write(path: pathlib.Path, content: bytes) -> None:
    """Writes a file so that it is there whole or not at all, whatever ends this process."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=path.parent, prefix=".", delete=False) as file:
        try:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
            os.replace(file.name, path)
        except BaseException:
            os.unlink(file.name)
            raise


def _storable(table: pyarrow.Table) -> pyarrow.Table:
    """Without columns of structs that have no members, which Parquet cannot hold."""
    empty = [field.name for field in table.schema if pyarrow.types.is_struct(field.type) and field.type.num_fields == 0]
    return table.drop_columns(empty)
