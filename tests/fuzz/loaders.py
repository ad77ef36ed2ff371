"""Random damage to every kind of file that is read: `python tests/fuzz/loaders.py MINUTES [SEED]`.

Each reader works in a process of its own, so that a crash is a finding too. What is found is told, and kept in
`build/fuzz` with the reader's name in the file's; the exit code is 1 then.
"""

from __future__ import annotations

import os
import random
import sys
import tempfile
import time
import traceback
from pathlib import Path

from mutations import mutated
from readers import Reader, make_readers

FINDINGS = Path(__file__).resolve().parents[2] / "build" / "fuzz"
_ROUND_SECONDS = 10.0


def main(minutes: float, seed: int) -> int:
    """Fuzz all readers in turn for so many minutes.  Returns 1 when anything was found."""
    end = time.monotonic() + 60.0 * minutes
    FINDINGS.mkdir(parents=True, exist_ok=True)
    runs, found = 0, 0
    with tempfile.TemporaryDirectory() as folder:
        readers = make_readers(Path(folder))
        for round_ in range(1 << 30):
            for reader in readers.values():
                seconds = min(_ROUND_SECONDS, end - time.monotonic())
                if seconds <= 0.0:
                    print(f"{runs} files, {found} findings")
                    return int(found > 0)
                done, failed = _in_child(reader, random.Random(f"{seed} {round_} {reader.name}"), seconds)
                runs, found = runs + done, found + failed
    return 0


def _in_child(reader: Reader, rng: random.Random, seconds: float) -> tuple[int, int]:
    """Files read, and 1 if the last of them was a finding."""
    current, counted = reader.folder / ".current", reader.folder / ".count"
    counted.write_text("0")
    child = os.fork()
    if child == 0:
        os._exit(_fuzz(reader, rng, seconds, current, counted))
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    if status == 0:
        return int(counted.read_text()), 0
    kept = FINDINGS / f"{reader.name.replace(' ', '_')}_{rng.getrandbits(32):08x}"
    kept.write_bytes(current.read_bytes())
    print(f"{reader.name}: {'killed by signal ' + str(-status) if status < 0 else 'see above'}: {kept}", flush=True)
    return int(counted.read_text()), 1


def _fuzz(reader: Reader, rng: random.Random, seconds: float, current: Path, counted: Path) -> int:
    end = time.monotonic() + seconds
    count = 0
    while time.monotonic() < end:
        data = mutated(reader.good, rng)
        current.write_bytes(data)
        count += 1
        counted.write_text(str(count))
        try:
            reader.outcome(data)
        except Exception:  # what a reader may raise is caught there
            traceback.print_exc()
            return 1
    return 0


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    sys.exit(main(float(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0))
