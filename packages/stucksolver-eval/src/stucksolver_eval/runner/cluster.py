"""Runs route jobs on other machines with dask.distributed (the extra [cluster] of the README).

A worker drives a route like this machine, in its own folder, and returns the files. Workers must be allowed to start
processes: `dask worker ADDRESS --no-nanny --nthreads 1`, one for every one or two cores.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path

from stucksolver.atomic_files import write_bytes
from stucksolver.privacy.private_files import make_private
from stucksolver_eval.results.outcome import RouteOutcome
from stucksolver_eval.runner.pool import RouteProgress
from stucksolver_eval.runner.route_process import RouteTask, run_task

CONNECT_S = 10
"""Time limit of the connection (s). Ours."""


class ClusterError(RuntimeError):
    """The cluster cannot be used. The message states the reason and the remedy."""


def run_on_cluster(tasks: Iterable[RouteTask], address: str) -> Iterator[RouteProgress]:
    """Run all tasks on the workers of a scheduler, and yield the result of each. Raises `ClusterError`."""
    try:
        from distributed import Client, as_completed
    except ImportError as error:
        raise ClusterError("dask.distributed is not installed: add the extra [cluster] (README, Install)") from error
    try:
        client = Client(address, timeout=CONNECT_S)
    except (OSError, ValueError) as error:
        raise ClusterError(
            f"no dask scheduler at address: {address}: {error}. Start one with `dask scheduler`"
        ) from error
    with client:
        todo = {client.submit(run_elsewhere, task, pure=False, retries=2): task for task in tasks}
        for future in as_completed(todo):
            task = todo[future]
            outcome, files = future.result()
            _keep(task.folder, files)
            yield RouteProgress(task, outcome=outcome)


PRIVATE = ("intervention-", "exchanges")
"""Prefixes of records and of requests to models. Only their owner may read them, as on the worker."""


def run_elsewhere(task: RouteTask) -> tuple[RouteOutcome, dict[str, bytes]]:
    """Drive a route on the worker. Returns the outcome, and all files by their paths in the folder."""
    with tempfile.TemporaryDirectory(prefix="stucksolver-") as name:
        folder = Path(name)
        outcome = run_task(RouteTask(task.job, folder))
        return outcome, {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def _keep(folder: Path, files: dict[str, bytes]) -> None:
    """Write the files from a worker. Outcomes come last, because they mark a route as done."""
    for name, data in sorted(files.items(), key=lambda item: "/outcomes/" in f"/{item[0]}"):
        path = (folder / name).resolve()
        if not path.is_relative_to(folder.resolve()):
            raise ClusterError(f"a worker returned a file outside of the results: {name}. Do not use this cluster")
        write_bytes(path, data)
        if path.name.startswith(PRIVATE) or path.suffix == ".jpg":
            make_private(path)
