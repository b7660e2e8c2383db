"""How well an OCR package reads the words on carlette's signs by distance, and its CPU time per crop.

`python -m benchmarks.sign_words [--weather night]`. Needs `rapidocr-onnxruntime` (Apache-2.0, includes weights of
PP-OCR), which no part of stucksolver uses: install it with stucksolver in a separate environment.
"""

from __future__ import annotations

import argparse
import importlib
import math
import statistics
import time
from collections.abc import Iterator
from typing import Any

import numpy as np

from carlette.camera.arrays import Bytes
from carlette.camera.models.signs import DETOUR, FACE_M, ROAD_CLOSED, post_sign
from carlette.camera.rendering import tags
from carlette.camera.rendering.renderer import Part
from carlette.camera.rendering.view import View, matrix_of
from carlette.geometry import Pose, Rotation
from carlette.maps import DEMO_TOWN
from carlette.opendrive.document import load_map
from carlette.opendrive.roads import RoadNetwork
from carlette.tools.gallery import Studio

SIGNS = {
    ("206", ""): "STOP",
    ("205", ""): "YIELD",
    ("274", "30"): "30",
    ("274", "50"): "50",
    ("274", "90"): "90",
    (ROAD_CLOSED, ""): "ROAD CLOSED",
    (DETOUR, ""): "DETOUR",
    ("101", ""): "",
    ("306", ""): "",
    ("267", ""): "",
}
"""Words on each sign; the last three have none."""
DISTANCES_M = (5, 10, 15, 20, 25, 30, 40)
RIGHT_M, NEAR_RIGHT_M = 3.0, 2.5
"""Lateral distance from the lane's centre; at 5 m slightly less, to be in the image."""
WIDTH_PX, HEIGHT_PX, FOV_DEG, EYE_M = 1600, 900, 70.0, 1.6
"""The camera of the shipped rig."""
HALF_M = 0.95
"""Half the width of the crop at the sign's distance; the sign's position is known from the map."""
CROP_PX = 192
"""Smaller crops are upscaled to this width."""
SURE = 0.6
MOST_TURNED_DEG = 12.0
WEATHERS: dict[str, dict[str, float]] = {"clear": {}, "night": {"altitude": -30.0}}


def crops(weather: str) -> Iterator[tuple[str, int, Bytes]]:
    """The words, the distance (m) and the crop (rows, columns, RGB) of each sign at each distance."""
    network = RoadNetwork(load_map(DEMO_TOWN))
    random = np.random.default_rng(1)
    focal = WIDTH_PX / 2.0 / math.tan(math.radians(FOV_DEG) / 2.0)
    for (kind, value), words in SIGNS.items():
        for away in DISTANCES_M:
            right = RIGHT_M if away > DISTANCES_M[0] else NEAR_RIGHT_M
            studio = Studio(network)
            studio.weather(**WEATHERS[weather])
            turned = studio.place(away, right, 0.0, 180.0 + float(random.uniform(-MOST_TURNED_DEG, MOST_TURNED_DEG)))
            studio.extra.append(Part(post_sign(kind, value), matrix_of(turned), 0, tags.TRAFFIC_SIGN))
            studio.world.tick()
            eye = Pose(studio.place(0.0, 0.0, EYE_M).location, Rotation(0.0, studio.spot.rotation.yaw, 0.0))
            rgb = studio.shoot(View(eye, WIDTH_PX, HEIGHT_PX, FOV_DEG))
            column, row = WIDTH_PX / 2 + focal * right / away, HEIGHT_PX / 2 - focal * (FACE_M - EYE_M) / away
            half = focal * HALF_M / away
            top, left = max(int(row - 0.8 * half), 0), int(column - half)
            yield words, away, rgb[top : int(row + 0.8 * half), left : int(column + half)]


def read(engine: Any, crop: Bytes) -> tuple[str, float]:
    """The letters and digits that were read, and the CPU time (ms)."""
    from PIL import Image

    picture = Image.fromarray(np.ascontiguousarray(crop))
    scale = max(1.0, CROP_PX / picture.width)
    picture = picture.resize((round(picture.width * scale), round(picture.height * scale)), Image.Resampling.BICUBIC)
    began = time.process_time()
    found, _ = engine(np.asarray(picture)[:, :, ::-1].copy(), use_cls=False)
    took_ms = 1e3 * (time.process_time() - began)
    text = "".join(str(one[1]) for one in found or () if float(one[2]) > SURE)
    return "".join(letter for letter in text.upper() if letter.isalnum()), took_ms


def main() -> None:
    """Prints one line per sign: whether it was read at each distance, and wrong readings."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--weather", choices=sorted(WEATHERS), default="clear")
    weather = parser.parse_args().weather
    engine = importlib.import_module("rapidocr_onnxruntime").RapidOCR(intra_op_num_threads=1, inter_op_num_threads=1)
    known = {words.replace(" ", "") for words in SIGNS.values()}
    times_ms = []
    told: dict[str, list[str]] = {}
    for words, away, crop in crops(weather):
        text, took_ms = read(engine, crop)
        times_ms.append(took_ms)
        right = text == words.replace(" ", "")
        wrong = not right and text in known and bool(text)
        told.setdefault(words or "no words", []).append(
            f"{away} m {'yes' if right else 'WRONG' if wrong else text or '-'}"
        )
    for name, line in told.items():
        print(f"{name}: {', '.join(line)}")
    print(f"median {statistics.median(times_ms):.0f} ms of CPU time per crop")


if __name__ == "__main__":
    main()
