"""The results on disk: one Parquet file a trial, whole or not at all, and all of them together."""

from __future__ import annotations

import os
import uuid
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rvdnav.errors import InputError
from rvdnav.extras import needs_extra
from rvdnav.files import read_text, write_text_atomically

with needs_extra("campaign", "campaigns"):
    import pyarrow as pa
    import pyarrow.parquet as pq

RESULTS = "results.parquet"
_PARTS = "trials"
_MARK = "campaign.digest"
SCHEMA = pa.schema(
    [
        ("trial", pa.string()),
        ("source", pa.string()),
        ("fault", pa.string()),
        ("seed", pa.int64()),
        ("timestamp_ns", pa.int64()),
        ("state", pa.string()),
        ("mode", pa.string()),
        ("reasons", pa.string()),
        ("published", pa.bool_()),
        ("range_m", pa.float64()),
        ("position_error_m", pa.float64()),
        ("attitude_error_rad", pa.float64()),
        ("nees", pa.float64()),
        ("wrong", pa.bool_()),
        ("seconds", pa.float64()),
    ]
)


def claim(out: Path, digest: str) -> None:
    """Make the campaign's folder, or take it up again.  Raises InputError where it holds anything else."""
    try:
        (out / _PARTS).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{out}: cannot be written: {error.strerror}") from error
    mark = out / _MARK
    if mark.exists():
        if read_text(mark).strip() != digest:
            raise InputError(f"{out}: holds a campaign of another plan; name another folder")
        return
    if {entry.name for entry in out.iterdir()} != {_PARTS} or any((out / _PARTS).iterdir()):
        raise InputError(f"{out}: is in the way and no campaign; name another folder")
    write_text_atomically(mark, digest + "\n")


def _part(out: Path, key: str) -> Path:
    return out / _PARTS / f"{key}.parquet"


def is_stored(out: Path, key: str) -> bool:
    """Whether a trial's rows are there."""
    return _part(out, key).exists()


def store_rows(out: Path, key: str, rows: Sequence[dict[str, Any]]) -> None:
    """Write a trial's rows under its own name: a second writer replaces them by the same rows."""
    _write(pa.Table.from_pylist(list(rows), SCHEMA), _part(out, key))


def collect(out: Path, keys: Sequence[str]) -> pa.Table:
    """The rows of all those trials in their order, each trial once, also written to RESULTS.

    Raises InputError naming a file that is missing or damaged.
    """
    tables = []
    for key in keys:
        part = _part(out, key)
        try:
            table = pq.read_table(part, schema=SCHEMA)
        except (OSError, pa.ArrowException) as error:
            raise InputError(f"{part}: cannot be read: {str(error).splitlines()[0]}") from error
        if set(table.column("trial").to_pylist()) - {key}:
            raise InputError(f"{part}: holds rows of another trial")
        tables.append(table)
    together = pa.concat_tables(tables)
    _write(together, out / RESULTS)
    return together


def _write(table: pa.Table, path: Path) -> None:
    temporary = path.with_name(f".{path.name}.{uuid.uuid4().hex}")
    try:
        pq.write_table(table, temporary)
        os.replace(temporary, path)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}") from error
    finally:
        temporary.unlink(missing_ok=True)
