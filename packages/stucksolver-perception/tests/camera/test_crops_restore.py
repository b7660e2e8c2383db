"""A training of the crop network goes on from the file that is shipped; needs torch and onnx."""

import numpy as np
import pytest

from stucksolver_perception.camera.crop_network import CropNetwork
from stucksolver_perception.camera.crops import CROP_PX, FEATURES
from stucksolver_perception.network_files import DATA

torch = pytest.importorskip("torch", reason="training needs torch")
pytest.importorskip("onnx", reason="training needs onnx")
from lab.perception.training.camera.crops_net import TRUNK_WIDTH, ExportedCropNet, restored  # noqa: E402
from lab.perception.training.camera.gesture_head_train import fit  # noqa: E402
from lab.training.restore import RestoreError, mean_of, settle  # noqa: E402

SHIPPED = DATA / "crops.onnx"


def given(seed: int) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(seed)
    crops = random.integers(0, 256, (6, CROP_PX, CROP_PX, 3), dtype=np.uint8)
    return crops, random.normal(0.0, 0.5, (6, FEATURES)).astype(np.float32)


def test_the_restored_network_computes_what_the_shipped_one_does() -> None:
    net, network = ExportedCropNet(restored(SHIPPED)).eval(), CropNetwork()
    crops, features = given(1)
    with torch.no_grad():
        mine = [item.numpy() for item in net(torch.from_numpy(crops), torch.from_numpy(features))]
    theirs = network._session.run(None, {"crops": crops, "features": features})
    assert len(mine) == len(theirs)
    for item, other in zip(mine, theirs, strict=True):
        assert np.abs(item - other).max() < 1e-2


def test_settling_keeps_the_output() -> None:
    net = restored(SHIPPED).eval()
    crops, features = given(2)
    pictures, known = torch.from_numpy(crops).permute(0, 3, 1, 2).float() / 255.0, torch.from_numpy(features)
    with torch.no_grad():
        before = net(pictures, known)
        settle(net, lambda: net(pictures, known))
        after = net(pictures, known)
    assert all((item - other).abs().max() < 2e-2 for item, other in zip(before, after, strict=True))


def test_another_network_is_named() -> None:
    with pytest.raises(RestoreError, match=r"far\.onnx"):
        restored(DATA / "far.onnx")


def test_mean_of_weights_uses_share_of_other_network() -> None:
    """The mean of a network and itself is that network, and the share is that of the other."""
    one, other = restored(SHIPPED), restored(SHIPPED)
    with torch.no_grad():
        other.heads[0].bias += 1.0
    mean = mean_of(one.state_dict(), other.state_dict(), 0.25)
    for name, value in one.state_dict().items():
        off = 0.25 if name == "heads.0.bias" else 0.0
        assert torch.allclose(mean[name].double(), value.double() + off, atol=1e-6), name


def test_fit_gesture_head_changes_no_other_weights() -> None:
    """The gesture head learns without a change of any other weight."""
    net = restored(SHIPPED).eval()
    before = {name: value.clone() for name, value in net.state_dict().items()}
    random = np.random.default_rng(3)
    gestures = torch.from_numpy(random.integers(0, 5, 400))
    # Numbers of very different size, of which a few tell the gesture.
    seen = torch.from_numpy(
        random.normal(3.0, 1.0, (400, TRUNK_WIDTH)) * random.uniform(0.1, 10.0, TRUNK_WIDTH)
    ).float()
    seen[torch.arange(400), gestures] += 200.0
    fit(net.gesture, seen, gestures, steps=600)
    with torch.no_grad():
        assert (net.gesture(seen).argmax(1) == gestures).float().mean() > 0.95
    for name, value in net.state_dict().items():
        assert name.startswith("gesture.") or torch.equal(value, before[name]), name
