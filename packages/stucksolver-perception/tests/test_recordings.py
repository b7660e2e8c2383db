"""A recording comes back as it was written, to a centimetre; what is none is refused in one clear sentence."""

from __future__ import annotations

import io
import json
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from stucksolver_perception.measurements import LidarSweep
from stucksolver_perception.recording import (
    GESTURES,
    KINDS,
    LightTruth,
    Recorded,
    Recording,
    RecordingError,
    RecordingWriter,
    Truth,
    recordings,
)
from stucksolver_perception.rig import load_rig

RIG = load_rig()


def jpeg(random):
    file = io.BytesIO()
    Image.fromarray(random.integers(0, 255, (9, 16, 3), np.uint8)).save(file, "JPEG")
    return file.getvalue()


def lights(random, count):
    heads = tuple(random.uniform(-300.0, 300.0, (int(random.integers(0, 3)), 7)) for _ in range(count))
    return LightTruth(random.integers(1, 999, count), random.integers(0, 5, count), heads)


def tick(time_s, seed, points, bodies, lit, drawn):
    """With so many points, bodies and lights (None: lights were not noted), and with a picture or without one."""
    random = np.random.default_rng(seed)
    rays = random.uniform(-300.0, 300.0, (points, 4)).astype(np.float32)
    rays[:, 3] = random.uniform(0.0, 1.0, points)
    truth = Truth(
        random.integers(1, 70000, bodies),
        random.integers(0, len(KINDS), bodies),
        random.uniform(-500.0, 500.0, (bodies, 9)),
        random.integers(-1, 2048, bodies),
        random.integers(-1, 16, bodies),
        random.integers(-1, len(GESTURES), bodies),
        random.integers(-1, 32, bodies),
        tuple(f"vehicle.kind{k}" for k in range(bodies)),
    )
    return Recorded(
        time_s=time_s,
        pose=random.normal(size=9),
        sweep=LidarSweep(time_s, rays),
        imu=random.normal(size=7),
        gnss=random.normal(size=3),
        wheel_mps=float(random.normal()),
        truth=truth,
        lights=None if lit is None else lights(random, lit),
        jpeg=jpeg(random) if drawn else None,
        instances=random.integers(0, 65536, (9, 16)).astype(np.uint16) if drawn else None,
    )


SHAPES = st.tuples(
    st.integers(0, 2**32), st.integers(0, 30), st.integers(0, 4), st.none() | st.integers(0, 3), st.booleans()
)


def written(folder, ticks, ticks_in_file=3):
    writer = RecordingWriter(folder, RIG, {"town": "demo_town"}, ticks_in_file=ticks_in_file)
    for item in ticks:
        writer.add(item)
    writer.close()
    return Recording(folder)


def assert_alike(one, other):
    """Exact but for what is kept in fewer bits."""
    assert (one.time_s, one.wheel_mps, one.jpeg) == (other.time_s, other.wheel_mps, other.jpeg)
    for name in ("pose", "imu", "gnss"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    assert one.sweep.time_s == other.sweep.time_s
    np.testing.assert_allclose(one.sweep.points[:, :3], other.sweep.points[:, :3], atol=0.00503)
    np.testing.assert_allclose(one.sweep.points[:, 3], other.sweep.points[:, 3], atol=0.00197)
    for name in ("actor_id", "kind", "lamps", "doors", "gesture", "shown"):
        np.testing.assert_array_equal(getattr(one.truth, name), getattr(other.truth, name))
    np.testing.assert_allclose(one.truth.boxes, other.truth.boxes, rtol=1e-6)
    assert one.truth.type_id == other.truth.type_id
    assert (one.instances is None) == (other.instances is None)
    if other.instances is not None:
        np.testing.assert_array_equal(one.instances, other.instances)
    assert (one.lights is None) == (other.lights is None)
    if one.lights is not None and other.lights is not None:
        np.testing.assert_array_equal(one.lights.light_id, other.lights.light_id)
        np.testing.assert_array_equal(one.lights.state, other.lights.state)
        assert [len(head) for head in one.lights.heads] == [len(head) for head in other.lights.heads]
        for ours, theirs in zip(one.lights.heads, other.lights.heads, strict=True):
            np.testing.assert_allclose(ours, theirs, rtol=1e-6)


@pytest.mark.integration
@settings(max_examples=30)
@given(st.lists(SHAPES, max_size=8))
def test_a_drive_comes_back_as_it_was_recorded(shapes):
    ticks = [tick(0.05 * k, *shape) for k, shape in enumerate(shapes)]
    with TemporaryDirectory() as folder:
        back = list(written(Path(folder), ticks))
    assert len(back) == len(ticks)
    for item, other in zip(back, ticks, strict=True):
        assert_alike(item, other)


@pytest.fixture
def drive(tmp_path):
    """A recording of five ticks."""
    return written(tmp_path / "drives" / "one", [tick(0.05 * k, k, 10, 2, 1, True) for k in range(5)])


def test_a_picture_is_read_with_the_size_it_was_drawn_in(drive):
    first = next(iter(drive))
    assert first.picture().shape == (9, 16, 3)
    assert tick(0.0, 0, 1, 1, None, False).picture() is None


def test_rig_and_notes_come_back_and_stretches_are_in_the_order_of_time(drive):
    assert drive.rig == RIG
    assert drive.about["town"] == "demo_town"
    assert [file.name for file in drive.files] == ["00000.npz", "00001.npz"]
    assert [item.time_s for item in drive.stretch(drive.files[1])] == pytest.approx([0.15, 0.2])


def test_a_drive_that_broke_off_is_read_as_far_as_it_was_written(tmp_path):
    writer = RecordingWriter(tmp_path, RIG, {}, ticks_in_file=2)
    for k in range(3):
        writer.add(tick(0.05 * k, k, 4, 1, None, False))
    assert len(list(Recording(tmp_path))) == 2
    assert not list(tmp_path.glob("*.part"))


def test_recordings_are_found_beneath_a_folder_or_as_the_folder_itself(drive):
    assert [recording.folder for recording in recordings(drive.folder.parent.parent)] == [drive.folder]
    assert [recording.folder for recording in recordings(drive.folder)] == [drive.folder]


def test_a_folder_without_recordings_is_named_with_the_remedy(tmp_path):
    with pytest.raises(RecordingError, match=r"no recordings found; make some with `python -m lab perception"):
        recordings(tmp_path)


@pytest.mark.parametrize("text", [None, "no JSON", "[1]"], ids=["nothing", "no-json", "no-table"])
def test_a_folder_that_is_no_recording_is_named(tmp_path, text):
    if text is not None:
        (tmp_path / "drive.json").write_text(text, encoding="utf-8")
    with pytest.raises(RecordingError, match=rf"{tmp_path.name}: this folder is not a recording"):
        Recording(tmp_path)


@pytest.mark.parametrize("version", [0, 1, None])
def test_a_recording_of_another_version_is_named_with_both_and_the_remedy(drive, version):
    file = drive.folder / "drive.json"
    about = json.loads(file.read_text(encoding="utf-8"))
    file.write_text(json.dumps({**about, "version": version}), encoding="utf-8")
    with pytest.raises(RecordingError, match=rf"recorded in format {version}, expected 2; record it again"):
        Recording(drive.folder)


@pytest.mark.parametrize(
    ("rig", "told"), [(None, "rig: "), ({**RIG.model_dump(), "gnss_noise_m": "much"}, r"rig\.gnss_noise_m: ")]
)
def test_a_recording_with_a_rig_that_cannot_be_read_is_named_with_the_field(drive, rig, told):
    file = drive.folder / "drive.json"
    about = json.loads(file.read_text(encoding="utf-8"))
    file.write_text(json.dumps({**about, "rig": rig}), encoding="utf-8")
    with pytest.raises(RecordingError, match=rf"one: drive\.json: {told}.*; record it again"):
        Recording(drive.folder)
