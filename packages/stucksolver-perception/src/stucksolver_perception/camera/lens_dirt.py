"""Notices dirt on a camera's lens: it stays at the same pixels while the scene moves.

Edges are watched, never areas: a sky or a dark road stays the same as well. Where the motion of the scene is known, an
edge across it cannot stay at its pixels; edges along it can (curbs, solid lines), and prove nothing. What else stays:

* A vehicle ahead at the same speed, clouds, houses far away. So while the vehicle drives straight on, only the road
  right ahead of the lens is watched, where no other vehicle is for long.
* The vehicle's own shadow, bonnet and light on that road. They are in one place, or one line. Dirt counts there only if
  it is spread over the width of the image.
* Dirt in one place must stay while the vehicle turns, which moves all the rest sideways, to the left and to the right:
  curbs, and a vehicle ahead, stay where they are all around a roundabout. It must not reach the lower edge of the
  image, as the vehicle's own parts do. At night, it counts only above the horizon: headlights draw edges on the road.

Nothing is learned while the vehicle stands: what is known of the lens stays known.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from stucksolver_perception.camera.static_edges import STILL, Mask, StaticEdges, covered_by, without_lines
from stucksolver_perception.measurements import CameraFrame, Pixels, PoseEstimate, Singles
from stucksolver_perception.rig import CameraRig

SAMPLES_WIDE = 400
"""Number of samples in a row of the image: in an image of 1600 px each is 4 px wide."""
COARSE = 4
"""In turns, samples are this many times as wide and high, for smears without sharp edges."""
NEAR_M = 7.5
"""Only the road nearer to the lens is watched while driving straight on. It moves by 40 px and more in each meter."""
DRIVEN_M = 1.0
"""Least distance between two looks at it."""
STRAIGHT_PER_M = 0.02
"""In narrower curves (radius below 50 m) it is not watched: there, lines stay at their pixels that are not straight."""
TURNED_RAD = math.radians(3.5)
"""Least turn between two looks at the whole image, which moves it by 70 px."""
SECTORS = 8
"""The width of the image is divided into so many sectors; ..."""
SPREAD_OVER = 5
"""... dirt in this many of them is spread."""
SPREAD = 0.0025
"""Least share of edges that prove dirt in such a sector. In healthy drives the fifth sector has none, with salt 2 %."""
NIGHT = 60.0
"""If the image is darker than this above the horizon (0 to 255), headlights draw edges on the road that stay in turns.
The simulator's nights have 36 to 54, its days, sunsets and rain 64 and more.
"""
LINE = 6
"""What is wider than a sector, with fewer samples in a column, is a line: the rim of a bonnet or of a shadow."""
PATCH = 12
"""Least number of coarse samples that prove dirt in turns. Healthy drives have none; in turns to one side, up to 5, and
more in a roundabout.
"""
GRAIN = 3
"""Least number of them in one piece."""
TOO_MUCH = 0.01
"""If dirt touches a larger share of the image, nothing in it is believed. With less, only what it touches is not read:
in grains of 24 px, 1 % of dirt touches one in 40 traffic lights at 50 m. With more, too little is left, and soft rims
reach further than the edges that are found.
"""


@dataclass(frozen=True, eq=False)
class LensDirt:
    """What is known of the dirt on a lens."""

    share: float
    """Share of the image that it touches, in the part of the image where it was looked for."""
    covered: Mask | None
    """(rows, columns): the image in equal cells, True where dirt is; None if that is known for the near road only."""

    @property
    def is_too_much(self) -> bool:
        """True if nothing in the image can be believed. Dirt that is spread may be anywhere else, too."""
        return self.covered is None or self.share >= TOO_MUCH


class LensMonitor:
    """Watches the lens of one camera that looks ahead or back. Not thread-safe."""

    def __init__(self, rig: CameraRig) -> None:
        self._side = max(2 * (rig.width_px // (2 * SAMPLES_WIDE)), 1)
        self._shape = rig.height_px // self._side, rig.width_px // self._side
        self._first = min(_near_row(rig) // self._side, self._shape[0] - 3)
        self._horizon = max(round(_vanishing_px(rig)[1]) // (COARSE * self._side), 3)
        """First coarse row below the horizon."""
        self._near = StaticEdges(*_away(rig, self._side, self._shape, self._first))
        flat = np.ones([cells // COARSE - 2 for cells in self._shape], np.float32)
        self._turns = tuple(StaticEdges(flat, np.zeros_like(flat)) for _ in ("to the right", "to the left"))
        self._driven_from: PoseEstimate | None = None
        self._turned_from: PoseEstimate | None = None
        self._spread: LensDirt | None = None
        self._patches: LensDirt | None = None

    @property
    def dirt(self) -> LensDirt | None:
        """What is known of the dirt; None if the lens is clean, as far as is known."""
        return self._spread or self._patches

    def checked(self, frame: CameraFrame, pose: PoseEstimate | None, camera: str) -> tuple[CameraFrame | None, str]:
        """Watch an image, and return what can be believed of it, and what is wrong with it in a few words.

        Args:
            frame: The image.
            pose: The vehicle's pose then; None if it stands.
            camera: The camera's name.
        """
        if pose is not None:
            self.watch(frame.rgb, pose)
        dirt = self.dirt
        if dirt is None:
            return frame, ""
        why = f"dirt on the lens touches {dirt.share:.1%} of the {camera}'s picture"
        return None if dirt.is_too_much else replace(frame, covered=dirt.covered), why

    def watch(self, rgb: Pixels, pose: PoseEstimate) -> None:
        """Watch an image (height, width, 3) of the moving vehicle."""
        driven, turned = self._driven_from or pose, self._turned_from or pose
        gone_m = math.hypot(pose.x_m - driven.x_m, pose.y_m - driven.y_m)
        if gone_m >= DRIVEN_M and abs(_turn_rad(driven, pose)) <= STRAIGHT_PER_M * gone_m:
            self._near.add(self._samples(rgb, self._first))
            self._spread = self._spread_dirt()
        turn_rad = _turn_rad(turned, pose)
        if abs(turn_rad) >= TURNED_RAD:
            samples = _coarse(self._samples(rgb, 0))
            sky = samples[: self._horizon]
            self._turns[turn_rad > 0.0].add(sky if sky.mean() < NIGHT else samples)
            self._patches = self._patches_of_dirt()
            turned = pose
        self._driven_from, self._turned_from = (pose if gone_m >= DRIVEN_M else driven), turned

    def _samples(self, rgb: Pixels, first: int) -> Singles:
        """Green of an image from a row of samples on, each the mean of four pixels."""
        if self._side == 1:
            return rgb[first:, :, 1].astype(np.float32)
        rows, columns = self._shape
        half = self._side // 2
        green = rgb[first * self._side :: half, ::half, 1][: 2 * (rows - first), : 2 * columns].astype(np.float32)
        pairs = green[::2] + green[1::2]
        return np.asarray(np.float32(0.25) * (pairs[:, ::2] + pairs[:, 1::2]))

    def _spread_dirt(self) -> LensDirt | None:
        """Dirt that is spread over the width of the image, by the near road."""
        proof = self._near.proving()
        wide = proof.shape[1] / SECTORS
        if _spread(proof) >= SPREAD and _spread(without_lines(proof, wide, LINE)) >= SPREAD:
            return LensDirt(covered_by(self._near.staying(), proof, GRAIN)[1], None)
        return self._spread if self._spread and _spread(self._near.proving(STILL)) >= SPREAD else None

    def _patches_of_dirt(self) -> LensDirt | None:
        """Dirt in any places, by the whole image in turns both ways."""
        right, left = self._turns
        proof = right.proving() & left.proving()
        if proof.sum() >= PATCH:
            covered, share = covered_by(right.staying() & left.staying(), proof, GRAIN)
            if (proof & covered).sum() >= PATCH:
                return LensDirt(share, np.pad(covered, 1))
        known = self._patches
        if known is None or known.covered is None:
            return None
        seen = right.proving(STILL) & left.proving(STILL) & known.covered[1:-1, 1:-1]
        return known if seen.sum() >= PATCH // 2 else None


def _vanishing_px(rig: CameraRig) -> tuple[float, float]:
    """Column and row of the point that the vehicle drives to, or comes from."""
    ahead, left, up = rig.mount.to_vehicle()[0, :3]
    return rig.width_px / 2.0 - rig.focal_px * left / ahead, rig.height_px / 2.0 - rig.focal_px * up / ahead


def _near_row(rig: CameraRig) -> int:
    """The row in which a flat road is `NEAR_M` from the lens."""
    return max(round(_vanishing_px(rig)[1] + rig.focal_px * rig.mount.z_m / NEAR_M), 0)


def _away(rig: CameraRig, side: int, shape: tuple[int, int], first: int) -> tuple[Singles, Singles]:
    """Direction in which the road moves, to the right and down, at all samples from a row on but the outermost."""
    y, x = side * (np.mgrid[first + 1 : shape[0] - 1, 1 : shape[1] - 1] + 0.5)
    column, row = _vanishing_px(rig)
    far = np.maximum(np.hypot(x - column, y - row), 1.0)
    return ((x - column) / far).astype(np.float32), ((y - row) / far).astype(np.float32)


def _turn_rad(sooner: PoseEstimate, later: PoseEstimate) -> float:
    return math.remainder(later.yaw_rad - sooner.yaw_rad, math.tau)


def _coarse(samples: Singles) -> Singles:
    rows, columns = samples.shape[0] // COARSE, samples.shape[1] // COARSE
    blocks = samples[: rows * COARSE, : columns * COARSE].reshape(rows, COARSE, columns, COARSE)
    return np.asarray(blocks.mean((1, 3)), np.float32)


def _spread(proof: Mask) -> float:
    """The share of samples with proof in the sector that has the `SPREAD_OVER`-th most of it."""
    shares = [float(part.mean()) for part in np.array_split(proof, SECTORS, axis=1)]
    return sorted(shares)[-SPREAD_OVER]
