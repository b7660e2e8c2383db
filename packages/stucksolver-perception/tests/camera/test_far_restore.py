"""A training of the far detector goes on from the file that is shipped; needs torch and onnx."""

from pathlib import Path

import numpy as np
import pytest

from stucksolver_perception.camera.horizon_strip import STRIP_ROWS
from stucksolver_perception.network_files import DATA, load_session

torch = pytest.importorskip("torch")
pytest.importorskip("onnx")
from lab.perception.training.camera.far_net import ExportedFarNet, restored, scaled  # noqa: E402
from lab.training.restore import RestoreError, settle  # noqa: E402

SHIPPED = DATA / "far.onnx"


def strip(seed: int) -> np.ndarray:
    rows = np.linspace(40.0, 180.0, STRIP_ROWS)[:, None, None] + np.zeros((1, 1600, 3))
    return np.clip(rows + np.random.default_rng(seed).normal(0.0, 25.0, rows.shape), 0, 255).astype(np.uint8)


def test_the_restored_network_computes_what_the_shipped_one_does() -> None:
    session, _ = load_session(SHIPPED, DATA / "far.json", 1, 1)
    net = ExportedFarNet(restored(SHIPPED)).eval()
    for seed in (1, 2):
        shown = strip(seed)[None]
        peaks, rest = session.run(None, {"strip": shown})
        with torch.no_grad():
            mine = [item.numpy() for item in net(torch.from_numpy(shown))]
        assert np.abs(mine[0] - peaks).max() < 5e-3
        assert np.abs(mine[1] - rest).max() < 5e-3


def test_settling_keeps_the_output() -> None:
    net = restored(SHIPPED).eval()
    shown = scaled(torch.from_numpy(strip(3)[None, :, :320]).permute(0, 3, 1, 2).float())
    with torch.no_grad():
        before = net(shown)
        settle(net, lambda: net(shown))
        assert (net(shown) - before).abs().max() < 2e-2


def test_another_network_is_named(tmp_path: Path) -> None:
    (tmp_path / "far.onnx").write_bytes(b"no network")
    for file in (tmp_path / "far.onnx", DATA / "crops.onnx"):
        with pytest.raises(RestoreError, match=str(file)):
            restored(file)
