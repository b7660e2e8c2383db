"""Route jobs on the workers of a dask scheduler."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("carla")

from stucksolver_eval.runner.cluster import ClusterError, _keep, run_on_cluster


def test_a_worker_cannot_write_elsewhere(tmp_path: Path) -> None:
    with pytest.raises(ClusterError, match="outside of the results"):
        _keep(tmp_path / "out", {"../gone.txt": b""})
    assert not (tmp_path / "gone.txt").exists()


def test_outcomes_are_written_last(tmp_path: Path) -> None:
    with pytest.raises(ClusterError):
        _keep(tmp_path, {"seed-1/outcomes/a.json": b"", "../gone.txt": b"", "seed-1/records/a.json": b""})
    assert not (tmp_path / "seed-1" / "outcomes").exists()


def test_a_scheduler_that_is_not_there_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr("stucksolver_eval.runner.cluster.CONNECT_S", 1)
    with pytest.raises(ClusterError, match=r"no dask scheduler at address: tcp://127\.0\.0\.1:9"):
        list(run_on_cluster([], "tcp://127.0.0.1:9"))


@pytest.mark.release
@pytest.mark.slow
@pytest.mark.integration
def test_two_workers_drive_a_suite_and_send_the_files_back(tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    from test_evaluation import evaluate, records, suite

    file = suite(tmp_path, 2)
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=False, dashboard_address=None
    ) as cluster:
        assert evaluate(file, tmp_path / "out", "--cluster", cluster.scheduler_address) == 0
    assert len(records(tmp_path / "out")) == 2
