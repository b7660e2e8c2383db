"""A training goes on from the file that is shipped; needs torch and onnx."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from tests.lidar.synthetic import drive

from stucksolver_perception.lidar.detector import DATA, WEIGHTS

torch = pytest.importorskip("torch")
pytest.importorskip("onnx")
from lab.perception.training.lidar import batches  # noqa: E402
from lab.perception.training.lidar.average import average  # noqa: E402
from lab.perception.training.lidar.data import load  # noqa: E402
from lab.perception.training.lidar.evaluate import predicted  # noqa: E402
from lab.perception.training.lidar.net import PillarNet, restore  # noqa: E402
from lab.perception.training.lidar.train import Options, train  # noqa: E402
from lab.training.restore import RestoreError, settle  # noqa: E402

SHIPPED = DATA / WEIGHTS


@pytest.fixture(scope="module")
def net() -> PillarNet:
    return restore(SHIPPED).eval()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("drive")
    drive(made, seed=5, ticks=16)
    return made


def cells(net: PillarNet, windows: int) -> "torch.Tensor":
    """Few of the cells hold something, as in a sweep."""
    torch.manual_seed(7)
    count = windows * net.grid.rows * net.grid.columns
    return torch.rand(count, net.widths[0]) * (torch.rand(count, 1) < 0.05)


def test_the_restored_network_finds_what_the_shipped_one_finds(net: PillarNet, folder: Path) -> None:
    from stucksolver_perception.lidar.detector import LidarDetector

    windows = load([folder], jobs=1)
    store = batches.WindowStore(windows, torch.device("cpu"))
    points = store.batch(torch.tensor([0]), vary=False).points.numpy()
    shipped = LidarDetector().detect(points, 4.0)
    restored = predicted(net, store)[0]
    sure = shipped.score > 0.5
    assert sure.any()
    away = np.hypot(*(shipped.center[sure, None, :2] - restored.center[None, :, :2]).transpose(2, 0, 1))
    assert (away.min(axis=1) < 0.5).all()


def test_settling_changes_what_is_kept_but_not_what_is_computed(net: PillarNet) -> None:
    x = cells(net, 2)
    settled = restore(SHIPPED)
    with torch.no_grad():
        before = net.maps(x, 2)
        settle(settled, lambda: settled.maps(x, 2))
        after = settled.eval().maps(x, 2)
        # In training, each normalization uses the statistics of the batch itself.
        training = settled.train().maps(x, 2)
        plain = restore(SHIPPED).train().maps(x, 2)
    for expected, got in zip(before, after, strict=True):
        torch.testing.assert_close(got, expected, atol=1e-3, rtol=1e-3)
    assert (training[0] - before[0]).abs().max() < 0.1
    assert (plain[0] - before[0]).abs().max() > 1.0


@pytest.mark.integration
def test_a_training_goes_on_from_the_shipped_file(folder: Path, tmp_path: Path) -> None:
    options = Options(
        (folder,), (folder,), tmp_path, minutes=1.0, steps=1, batch=2, jobs=1, device="cpu", rate=1e-9, start=SHIPPED
    )
    train(options)
    mine = torch.load(tmp_path / "lidar.pt", weights_only=True)["weights"]
    for name, value in restore(SHIPPED).state_dict().items():
        if "point" in name or "join" in name or name.endswith("0.weight"):
            torch.testing.assert_close(mine[name], value, atol=1e-4, rtol=1e-4)


def test_the_average_lies_between(tmp_path: Path) -> None:
    for name in ("first", "second"):
        shutil.copytree(DATA, tmp_path / name)
    average(tmp_path / "first" / WEIGHTS, tmp_path / "second" / WEIGHTS, 0.3, tmp_path / "out")
    kept = torch.load(tmp_path / "out" / "lidar.pt", weights_only=True)
    for name, value in restore(SHIPPED).state_dict().items():
        torch.testing.assert_close(kept["weights"][name], value)
    assert json.loads((tmp_path / "out" / "training.json").read_text(encoding="utf-8"))["averaged"] == 0.3
    (tmp_path / "second" / "card.json").unlink()
    with pytest.raises(RestoreError, match=r"no card of a training: .*card\.json"):
        average(tmp_path / "first" / WEIGHTS, tmp_path / "second" / WEIGHTS, 0.3, tmp_path / "out")


@pytest.mark.parametrize("content", [b"", b"not a network", None])
def test_another_file_is_named(tmp_path: Path, content: bytes | None) -> None:
    file = tmp_path / "lidar.onnx"
    if content is None:
        from stucksolver_perception.camera import far_detector

        shutil.copy(Path(far_detector.__file__).with_name("data") / "far.onnx", file)
    else:
        file.write_bytes(content)
    with pytest.raises(RestoreError, match=r"no LiDAR network to continue from: .*lidar\.onnx"):
        restore(file)
