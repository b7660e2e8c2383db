"""What is taught is what the detector does with the answers; needs torch."""

from pathlib import Path

import numpy as np
import pytest
from tests.lidar.synthetic import drive

from stucksolver_perception.lidar.decode import decode
from stucksolver_perception.lidar.grid import GRID
from stucksolver_perception.lidar.pillars import pillars
from stucksolver_perception.lidar.sweeps import SweepBuffer
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import LidarSweep, PoseEstimate
from stucksolver_perception.recording import Recording

torch = pytest.importorskip("torch")
from lab.perception.training.lidar import batches, evaluate, loss  # noqa: E402
from lab.perception.training.lidar.data import IGNORED, load, returns_in  # noqa: E402
from lab.perception.training.lidar.net import strongest  # noqa: E402
from lab.perception.training.lidar.pillars import pillars as torch_pillars  # noqa: E402
from lab.perception.training.lidar.train import Options, one_cycle, train  # noqa: E402

CAR, PEDESTRIAN = LABELS.index("car"), LABELS.index("pedestrian")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("drive")
    drive(made, seed=3, ticks=16)
    return made


def padded(*boxes: tuple[int, list[float]]) -> tuple["torch.Tensor", "torch.Tensor"]:
    return torch.tensor([[box for _, box in boxes]]), torch.tensor([[label for label, _ in boxes]])


def test_training_and_detector_make_the_same_pillars() -> None:
    random = np.random.default_rng(0)
    points = random.uniform((-60, -60, -4, 0, 0), (95, 60, 6, 1, 0.5), (20_000, 5)).astype(np.float32)
    features, cell = pillars(points)
    theirs, their_cell = torch_pillars(torch.from_numpy(points), torch.ones(len(points), dtype=torch.int64))
    assert len(cell) > 5_000
    np.testing.assert_array_equal(their_cell.numpy() - GRID.pillars, cell)
    np.testing.assert_allclose(theirs.numpy(), features, atol=1e-5)


@pytest.mark.parametrize("most", [60_000, 4_800])
def test_training_and_detector_gather_the_same_points(folder: Path, most: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(batches, "MAX_POINTS", most)
    windows = load([folder], jobs=1)
    last = len(windows) - 1
    ours = batches.WindowStore(windows, torch.device("cpu")).batch(torch.tensor([last]), vary=False).points.numpy()
    buffer = SweepBuffer(max_points=most)
    for tick in list(Recording(folder))[: windows.history[last, 0] + 1]:
        now = PoseEstimate(tick.time_s, *tick.pose[:4].tolist(), 0.0, 0.0, np.eye(4))
        buffer.add(LidarSweep(tick.time_s, tick.sweep.points), now)
    np.testing.assert_allclose(buffer.gather(now), ours, atol=2e-3)


def test_varied_boxes_still_lie_on_their_points(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(batches, "LEAST_KEPT", 1.0)
    monkeypatch.setattr(batches, "RANGE_NOISE_M", 0.0)
    monkeypatch.setattr(batches, "SCALE", 0.0)
    store = batches.WindowStore(load([folder], jobs=1), torch.device("cpu"))
    plain = store.batch(torch.tensor([0, 1]), vary=False)
    points, window, boxes = batches.varied(plain.points, plain.window, plain.boxes)
    for i in range(2):
        before = returns_in(plain.boxes[i, :, :9].double().numpy(), plain.points[plain.window == i].numpy())
        after = returns_in(boxes[i, :, :9].double().numpy(), points[window == i].numpy())
        assert before.sum() > 500
        np.testing.assert_allclose(after, before, atol=2)


def test_what_is_taught_decodes_to_the_same_boxes() -> None:
    car = [20.3, -4.1, 0.7, 4.4, 1.8, 1.5, 2.5, -3.0, 1.0, 50.0]
    person = [6.1, 3.2, 0.9, 0.5, 0.6, 1.7, -1.0, 0.5, -1.2, 20.0]
    boxes, labels = padded((CAR, car), (PEDESTRIAN, person))
    aim = loss.targets(boxes, labels)
    heat = torch.logit(aim.heat.clamp(1e-4, 1 - 1e-4))
    box = torch.zeros(1, 10, GRID.cells)
    box[0, :, aim.place[:, 1]] = aim.regressed.T
    parts = strongest(heat, box.reshape(1, 10, GRID.rows, GRID.columns))
    found = decode(*(part.numpy() for part in parts), 0.0, evaluate.RAW)
    by_label = {int(found.label[i]): i for i in range(2)}
    assert len(found) == 2
    for label, expected in ((CAR, car), (PEDESTRIAN, person)):
        i = by_label[label]
        got = [*found.center[i], *found.size[i], found.yaw[i], *found.velocity[i]]
        np.testing.assert_allclose(got, expected[:9], atol=1e-3)


def test_cells_beside_the_middle_are_taught_the_same_box() -> None:
    boxes, labels = padded((CAR, [20.3, -4.1, 0.7, 4.4, 1.8, 1.5, 2.5, -3.0, 1.0, 50.0]))
    aim = loss.targets(boxes, labels)
    cell = aim.place[:, 1]
    x = GRID.x_min_m + (cell // GRID.columns + 0.5 + aim.regressed[:, 0]) * GRID.cell_m
    y = GRID.y_min_m + (cell % GRID.columns + 0.5 + aim.regressed[:, 1]) * GRID.cell_m
    assert len(cell) == 9
    np.testing.assert_allclose(torch.stack([x, y], 1), [[20.3, -4.1]] * 9, atol=1e-4)


def test_the_area_of_an_ignored_body_is_no_background() -> None:
    boxes, labels = padded((IGNORED, [20.0, 0.0, 0.7, 10.0, 2.5, 1.5, 0.0, 0.0, 0.0, 0.0]))
    aim = loss.targets(boxes, labels)
    area = float((1.0 - aim.counted).sum()) * GRID.cell_m**2
    assert 25.0 < area < 60.0
    wild = torch.full((1, len(LABELS), GRID.rows, GRID.columns), -9.0)
    there = torch.where(aim.counted < 0.5, 5.0, wild)
    nothing = torch.zeros(1, 10, GRID.rows, GRID.columns)
    assert float(loss.losses(there, nothing, aim)[0]) < 0.05
    elsewhere = torch.where(aim.counted.roll(60, dims=2) < 0.5, 5.0, wild)
    assert float(loss.losses(elsewhere, nothing, aim)[0]) > 50.0


def test_targets_of_object_without_front_use_one_yaw() -> None:
    """An object without a distinct back is taught one of its two yaw angles."""
    barrier = LABELS.index("barrier")
    taught = []
    for yaw in (0.4, 0.4 + np.pi):
        boxes, labels = padded((barrier, [20.0, 0.0, 0.5, 2.0, 0.5, 1.0, yaw, 0.0, 0.0, 50.0]))
        taught.append(loss.targets(boxes, labels).regressed[:, 6:8])
    np.testing.assert_allclose(taught[0], taught[1], atol=1e-6)


def test_average_precision_by_hand() -> None:
    right = np.array([True, False, True, False])
    found = evaluate.ScoredDetections(np.array([0.9, 0.8, 0.7, 0.1]), right, np.zeros((2, 4)), bodies=4)
    assert evaluate.average_precision(found) == pytest.approx((1.0 + 2.0 / 3.0) / 4.0)


def test_a_calibrated_score_is_the_share_that_is_right() -> None:
    random = np.random.default_rng(1)
    score = random.uniform(0.05, 0.95, 4000)
    right = random.uniform(size=4000) < score**2
    slope, shift = evaluate._platt(score, right)
    logit = np.log(score / (1 - score))
    told = 1.0 / (1.0 + np.exp(-(slope * logit + shift)))
    for low in (0.1, 0.4, 0.7):
        band = (told > low) & (told < low + 0.2)
        assert right[band].mean() == pytest.approx(told[band].mean(), abs=0.06)


def test_the_learning_rate_rises_and_falls() -> None:
    rates = [one_cycle(share) for share in (0.0, 0.05, 0.1, 0.5, 1.0)]
    assert rates[0] < rates[1] < rates[2] == 1.0 > rates[3] > rates[4]


@pytest.mark.integration
@pytest.mark.parametrize("integers", [False, True])
def test_a_trained_network_runs_in_the_detector(folder: Path, tmp_path: Path, integers: bool) -> None:
    pytest.importorskip("onnx")
    from lab.perception.training.lidar.export import export
    from stucksolver_perception.lidar.detector import LidarDetector

    options = Options((folder,), (folder,), tmp_path / "run", minutes=1.0, steps=3, batch=2, jobs=1, device="cpu")
    assert [row["label"] for row in train(options)] == list(LABELS)
    card = export(tmp_path / "run", [folder], tmp_path / "shipped", [folder] if integers else [])
    assert card["shipped"]["off_by"] < 1e-3
    assert card["int8"] is integers
    windows = load([folder], jobs=1)
    points = batches.WindowStore(windows, torch.device("cpu")).batch(torch.tensor([0]), vary=False).points.numpy()
    found = LidarDetector(tmp_path / "shipped").detect(points, 4.0)
    assert found.time_s == 4.0
    assert found.center.shape == (len(found), 3)
