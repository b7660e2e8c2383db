"""Words read on carlette's signs by distance, words that are read without a sign, and the time.

`python -m lab.benchmarks.sign_words [--weather night] [--drives FOLDER --every N --save OUT]`. It requires the extra
`signs`. With `--drives`, crops of the pictures of recorded drives are read instead, chosen as for a stopped vehicle,
and each word is listed with its position.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from carlette.camera.arrays import Bytes
from carlette.camera.models.lettering import lettering
from carlette.camera.models.mesh import Builder, Mesh
from carlette.camera.models.signs import (
    BLACK,
    DETOUR,
    FACE_M,
    FRONT,
    READERS_RIGHT,
    ROAD_CLOSED,
    UP,
    WHITE,
    post_sign,
)
from carlette.camera.rendering import tags
from carlette.camera.rendering.renderer import RenderPart
from carlette.camera.rendering.view import CameraView, matrix_of
from carlette.geometry import Pose, Rotation
from carlette.maps import DEMO_TOWN
from carlette.opendrive.map_file import load_map
from carlette.opendrive.road_network import RoadNetwork
from carlette.tools.gallery import Studio
from stucksolver.scene import SignWord
from stucksolver_perception.camera.sign_reader import SignReader
from stucksolver_perception.camera.sign_targets import SignTarget, swaths, targets
from stucksolver_perception.lidar_labels import LABEL_OF_KIND
from stucksolver_perception.measurements import Floats, PoseEstimate
from stucksolver_perception.recording import KINDS, Recorded, recordings
from stucksolver_perception.rig import CameraRig, load_rig
from stucksolver_perception.tracking import Track

SIGNS: dict[tuple[str, str], SignWord | None] = {
    ("206", ""): SignWord.STOP,
    ("205", ""): SignWord.YIELD,
    (ROAD_CLOSED, ""): SignWord.ROAD_CLOSED,
    (DETOUR, ""): SignWord.DETOUR,
    ("101", ""): None,
    ("306", ""): None,
    ("267", ""): None,
    ("274", "30"): None,
    ("274", "50"): None,
    ("274", "90"): None,
}
"""The word on each sign that carlette draws; None for no word, or one that is not on the list."""
PLATES: dict[tuple[str, ...], SignWord | None] = {
    ("SLOW",): SignWord.SLOW,
    ("ROAD", "WORK", "AHEAD"): SignWord.ROAD_WORK,
    ("DO NOT", "ENTER"): SignWord.DO_NOT_ENTER,
    ("STOP", "AHEAD"): None,
    ("BUS", "STOP"): None,
    ("SHOP",): None,
    ("FIELD",): None,
    ("POLICY",): None,
    ("EXIT",): None,
    ("CLOSED",): None,
    ("ROAD", "OPEN"): None,
    ("SLOW", "FOOD"): None,
    ("FILE",): None,
    ("TOUR",): None,
}
"""Plates of this benchmark: words that carlette's signs lack, and words that resemble those of the list."""
DISTANCES_M = (5, 8, 10, 15, 20, 25, 30, 40)
"""Distances of the signs (m)."""
RIGHT_M, NEAR_RIGHT_M = 3.0, 2.5
"""Lateral distance from the lane's center (m); at 5 m slightly less, to be in the image."""
HALF_M = 0.95
"""Half the width of the crop at the sign's distance, if its position is known (m)."""
MOST_TURNED_DEG = 12.0
"""Maximum rotation of a sign (degrees)."""
WEATHERS: dict[str, dict[str, float]] = {"clear": {}, "night": {"altitude": -30.0}}
"""Parameters of the weather by name."""


@dataclass(frozen=True)
class Shot:
    """A sign in a picture."""

    name: str
    word: SignWord | None
    away_m: int
    rgb: Bytes
    column: float
    row: float
    """Row of the center of its face (px)."""


def plate(lines: Sequence[str]) -> Mesh:
    """Return a white plate with black lines, as wide as the longest, at the height of signs."""
    builder = Builder(tags.TRAFFIC_SIGN)
    half, high = 0.1 * max(map(len, lines)) + 0.08, 0.18 * len(lines) + 0.06
    corners = [(0.06, y * half, FACE_M + z * high) for y, z in ((1, 1), (-1, 1), (-1, -1), (1, -1))]
    builder.face(corners, WHITE, FRONT)
    for number, line in enumerate(lines):
        up_m = 0.36 * ((len(lines) - 1) / 2.0 - number)
        lettering(builder, line, (0.09, 0.0, FACE_M + up_m), READERS_RIGHT, UP, 0.26, BLACK)
    return builder.mesh()


def shots(weather: str, rig: CameraRig) -> Iterator[Shot]:
    """Yield each sign at each distance."""
    network = RoadNetwork(load_map(DEMO_TOWN))
    random = np.random.default_rng(1)
    eye_m = rig.mount.z_m
    made = [(f"{kind} {value}".strip(), post_sign(kind, value), word) for (kind, value), word in SIGNS.items()]
    made += [(" ".join(lines), plate(lines), word) for lines, word in PLATES.items()]
    for name, mesh, word in made:
        for away in DISTANCES_M:
            right = RIGHT_M if away > DISTANCES_M[0] else NEAR_RIGHT_M
            studio = Studio(network)
            studio.weather(**WEATHERS[weather])
            turned = studio.pose_at(away, right, 0.0, 180.0 + float(random.uniform(-MOST_TURNED_DEG, MOST_TURNED_DEG)))
            studio.extra.append(RenderPart(mesh, matrix_of(turned), 0, tags.TRAFFIC_SIGN))
            studio.world.tick()
            eye = Pose(studio.pose_at(0.0, 0.0, eye_m).location, Rotation(0.0, studio.spot.rotation.yaw, 0.0))
            rgb = studio.shoot(CameraView(eye, rig.width_px, rig.height_px, rig.fov_deg))
            column = rig.width_px / 2 + rig.focal_px * right / away
            row = rig.height_px / 2 - rig.focal_px * (FACE_M - eye_m) / away
            yield Shot(word.value if word else name, word, away, rgb, column, row)


def around(shot: Shot, rig: CameraRig) -> SignTarget:
    """Return the crop around a sign whose position is known."""
    half = rig.focal_px * HALF_M / shot.away_m
    left, top = max(int(shot.column - half), 0), max(int(shot.row - 0.8 * half), 0)
    right, bottom = min(int(shot.column + half), rig.width_px), int(shot.row + 0.8 * half)
    return SignTarget("sign", left, top, right, bottom)


class Timed:
    """A reader that notes the time of each crop."""

    def __init__(self) -> None:
        self._reader = SignReader()
        self.cpu_ms: list[float] = []

    def read(self, rgb: Bytes, target: SignTarget) -> Counter[SignWord]:
        """Return the words in a part of an image."""
        began = time.process_time()
        found = self._reader.read(target.crop(rgb), target.single)
        self.cpu_ms.append(1e3 * (time.process_time() - began))
        return Counter(item.word for item in found)


def measure_signs(weather: str, rig: CameraRig) -> None:
    """Print one line per sign, and the total of the words."""
    reader = Timed()
    for kind in ("known place", "road ahead"):
        found_words: dict[str, list[str]] = {}
        counts: Counter[str] = Counter()
        reader.cpu_ms.clear()
        for shot in shots(weather, rig):
            parts = (
                [around(shot, rig)] if kind == "known place" else [swath for swath in swaths(rig) if swath is not None]
            )
            words = set().union(*(reader.read(shot.rgb, part) for part in parts))
            wrong = words - {shot.word}
            answer = "WRONG " + "+".join(item.value for item in wrong) if wrong else "yes" if words else "-"
            found_words.setdefault(shot.name, []).append(f"{shot.away_m} m {answer}")
            sort = "with a word" if shot.word else "without"
            counts[f"{sort}: {'wrong' if wrong else 'read' if words else 'nothing'}"] += 1
        print(f"{kind}, {weather}")
        for name, line in found_words.items():
            print(f"  {name}: {', '.join(line)}")
        print(
            f"  {dict(counts)}; median {statistics.median(reader.cpu_ms):.0f} ms of CPU time per crop, "
            f"slowest {max(reader.cpu_ms):.0f}"
        )


def measure_drives(folder: Path, every: int, save: Path | None) -> None:
    """Print each word found in the pictures of recorded drives, and the number of crops."""
    reader = Timed()
    found = 0
    for drive in recordings(folder):
        pictures = (tick for tick in drive if tick.jpeg is not None)
        for number, tick in enumerate(pictures):
            rgb = tick.picture() if number % every == 0 else None
            if rgb is None:
                continue
            for target in targets(drive.rig.camera, pose_of(tick), list(tracks_of(tick)), {}):
                words = reader.read(rgb, target)
                found += len(words)
                for word in words:
                    name = f"{drive.folder.name}-{tick.time_s:.1f}-{target.key}-{word.value}"
                    print(f"  {name}: {type_of(tick, target)}")
                    if save is not None:
                        keep(rgb, target, save / f"{name}.jpg")
    count = len(reader.cpu_ms)
    print(
        f"{found} words in {count} crops, {1e3 * found / count:.1f} per 1,000; "
        f"median {statistics.median(reader.cpu_ms):.0f} ms of CPU time per crop"
    )


def keep(rgb: Bytes, target: SignTarget, file: Path) -> None:
    """Save a crop."""
    from PIL import Image

    file.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(np.ascontiguousarray(target.crop(rgb))).save(file)


def type_of(tick: Recorded, target: SignTarget) -> str:
    """Return the blueprint of the object in a crop."""
    return "ahead" if target.track_id is None else tick.truth.type_id[target.track_id]


def pose_of(tick: Recorded) -> PoseEstimate:
    """Return the true pose."""
    x, y, z, yaw = (float(item) for item in tick.pose[:4])
    return PoseEstimate(tick.time_s, x, y, z, yaw, 0.0, 0.0, np.eye(4))


def tracks_of(tick: Recorded) -> Iterator[Track]:
    """Yield the true bodies as stationary tracks, by their index."""
    for i, (box, kind) in enumerate(zip(tick.truth.boxes, tick.truth.kind, strict=True)):
        label = LABEL_OF_KIND.get(KINDS[int(kind)])
        if label is not None:
            yield track_of(i, tick.time_s, label, box)


def track_of(number: int, time_s: float, label: int, box: Floats) -> Track:
    """Return a track with this box, see `recording.BOX_COLUMNS`."""
    x, y, z, yaw, length, width, height = (float(item) for item in box[:7])
    return Track(
        number, time_s, label, 1.0, 1.0, x, y, z, yaw, 0.0, 0.0, length, width, height, np.eye(5), 0.0, time_s, 9,
        False, 0.0, None,
    )  # fmt: skip


def main() -> None:
    """Read signs, or the pictures of drives."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--weather", choices=sorted(WEATHERS), default="clear")
    parser.add_argument("--drives", type=Path, help="folder of recordings (`python -m lab perception collect`)")
    parser.add_argument("--every", type=int, default=5, help="number of pictures per picture that is used")
    parser.add_argument("--save", type=Path, help="folder for the crops in which a word was found")
    options = parser.parse_args()
    if options.drives is not None:
        measure_drives(options.drives, options.every, options.save)
    else:
        measure_signs(options.weather, load_rig().camera)


if __name__ == "__main__":
    main()
