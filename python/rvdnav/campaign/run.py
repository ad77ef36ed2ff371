"""The campaign's run: joblib hands the work to this machine's cores or to a cluster."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import attrs

from rvdnav.campaign.plan import Plan
from rvdnav.campaign.store import claim, collect
from rvdnav.campaign.trial import prepare, run_trial
from rvdnav.errors import InputError
from rvdnav.extras import needs_extra

with needs_extra("campaign", "campaigns"):
    import joblib
    import pyarrow as pa

BACKENDS = ("local", "dask", "ray")
Progress = Callable[[str, int, int], None]


@attrs.frozen
class Pool:
    """Who does the work.

    backend: one of BACKENDS: this machine's cores, or the cluster of Dask or Ray whose scheduler is at that address;
    one of its own on this machine without it.  Its workers must see the campaign's folder under the same path.  jobs:
    at once; -1 for as many as there are cores.
    """

    backend: str = "local"
    scheduler: str | None = None
    jobs: int = -1


def run_campaign(plan: Plan, out: str | Path, pool: Pool | None = None, progress: Progress | None = None) -> pa.Table:
    """Run what is not done yet of a plan in the folder `out`; the rows of all of it (see `store.SCHEMA`).

    Every trial's result is a file of its own, written whole and named by the trial: work that is lost with a worker is
    done again, work that is done twice counts once, and an interrupted campaign goes on where it stopped.
    progress: called with what is being done, and the numbers done and wanted.  Raises InputError.
    """
    folder = Path(out).resolve()
    claim(folder, plan.digest)
    tell = progress or (lambda what, done, total: None)
    with _workers(pool or Pool()) as parallel:
        _each(parallel, prepare, [source for source in plan.sources if source.seed is not None], folder, "scenes", tell)
        _each(parallel, run_trial, plan.trials, folder, "trials", tell)
    return collect(folder, [trial.key for trial in plan.trials])


def _each(
    parallel: Any, work: Callable[[Any, Path], Any], items: Sequence[Any], folder: Path, what: str, tell: Progress
) -> None:
    tell(what, 0, len(items))
    done = parallel(joblib.delayed(work)(item, folder) for item in items)
    for count, _ in enumerate(done, start=1):
        tell(what, count, len(items))


@contextmanager
def _workers(pool: Pool) -> Iterator[Any]:
    if pool.backend == "local":
        if pool.scheduler is not None:
            raise InputError("--scheduler: only a Dask or Ray cluster has one")
        yield joblib.Parallel(n_jobs=pool.jobs, return_as="generator_unordered")
        return
    connect = _dask if pool.backend == "dask" else _ray
    with connect(pool.scheduler), joblib.parallel_config(backend=pool.backend, n_jobs=pool.jobs):
        yield joblib.Parallel(return_as="generator_unordered" if pool.backend == "dask" else "list")


@contextmanager
def _dask(scheduler: str | None) -> Iterator[None]:
    with needs_extra("dask", "--backend dask"):
        import distributed
    dask: Any = distributed  # its types are incomplete
    cluster = dask.LocalCluster(dashboard_address=None) if scheduler is None else None
    try:
        client = dask.Client(cluster if scheduler is None else scheduler)
    except (OSError, ValueError) as error:
        raise InputError(f"--scheduler {scheduler}: cannot be reached") from error
    try:
        with client:
            yield
    finally:
        if cluster is not None:
            cluster.close()


@contextmanager
def _ray(scheduler: str | None) -> Iterator[None]:
    with needs_extra("ray", "--backend ray"):
        import ray
        from ray.util import joblib as bridge
    try:
        ray.init(address=scheduler, log_to_driver=False)
    except ConnectionError as error:
        raise InputError(f"--scheduler {scheduler}: cannot be reached") from error
    register: Any = bridge.register_ray  # untyped
    register()
    try:
        yield
    finally:
        ray.shutdown()
