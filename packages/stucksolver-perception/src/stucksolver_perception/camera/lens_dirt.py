"""Detects dirt on a camera's lens, which stays at the same pixels while the scene moves.

Only edges are used, never areas, because the sky or a dark road also stays the same. Where the motion of the scene is
known, an edge across it cannot stay at its pixels. Edges along it can (curbs, solid lines), and prove nothing. Other
edges that stay:

* A vehicle ahead at the same speed, clouds, far houses. So while the vehicle drives straight, only the road directly
  ahead of the lens is used, where no other vehicle stays for long.
* The vehicle's own shadow, hood and light on that road. They are in one place, or on one line. Dirt counts there only
    if
  it is spread over the width of the image.
* Dirt in one place must stay while the vehicle turns to the left and to the right, which moves the rest of the image
  sideways. Turns to one side are not enough: curbs and a vehicle ahead stay in place all around a roundabout. The dirt
  must not reach the lower edge of the image, as the vehicle's own parts do. At night, it counts only above the horizon,
  because headlights draw edges on the road.

While the vehicle is stopped, nothing changes: known dirt stays known.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from stucksolver_perception.camera.static_edges import KNOWN_LENGTH, Mask, StaticEdges, covered_by, without_lines
from stucksolver_perception.measurements import CameraFrame, Pixels, PoseEstimate, Singles
from stucksolver_perception.rig import CameraRig

SAMPLES_WIDE = 400
"""Number of samples in a row of the image. In an image of 1600 px each is 4 px wide."""
COARSE = 4
"""Factor of the samples' size in turns, for smears without sharp edges. Ours."""
NEAR_M = 7.5
"""Distance from the lens up to which the road is used while driving straight (m). It moves by 40 px and more per meter
of travel."""
MIN_DRIVEN_M = 1.0
"""Minimum travel between two images of the near road (m). Ours."""
STRAIGHT_PER_M = 0.02
"""Maximum curvature for the near road (1/m; radius 50 m). In tighter curves, bent lines stay at their pixels. Ours."""
MIN_TURN_RAD = math.radians(3.5)
"""Minimum turn between two uses of the whole image (rad), which moves it by 70 px. Ours."""
SECTORS = 8
"""Number of sectors in the width of the image. Ours."""
SPREAD_SECTORS = 5
"""Minimum number of sectors with dirt for spread dirt. Ours."""
MIN_SPREAD = 0.0025
"""Minimum share of edges that prove dirt in such a sector. The fifth sector has none in healthy drives, and 2 % with
salt."""
NIGHT_BRIGHTNESS = 60.0
"""Brightness above the horizon (0 to 255) below which headlights draw edges on the road that stay in turns. The
simulator's nights have 36 to 54; its days, sunsets and rain have 64 and more."""
LINE_SAMPLES = 6
"""Number of samples per column below which a piece wider than a sector is a line: the rim of a hood or of a shadow.
Ours."""
MIN_PATCH = 12
"""Minimum number of coarse samples that prove dirt in turns. Healthy drives have none; turns to one side have up to 5,
and roundabouts more."""
MIN_GRAIN = 3
"""Minimum number of proving samples in one piece. Ours."""
MAX_SHARE = 0.01
"""Share of dirt above which the image is not used at all. Below it, only the parts that dirt touches are not read.

In grains of 24 px, 1 % of dirt touches one in 40 traffic lights at 50 m. With more dirt, too little of the image
remains, and soft rims extend beyond the detected edges."""


@dataclass(frozen=True, eq=False)
class LensDirt:
    """The known dirt on a lens."""

    share: float
    """Share of the examined part of the image that the dirt touches."""
    covered: Mask | None
    """(rows, columns): the image in equal cells, True for cells with dirt; None if only the near road was examined."""

    @property
    def is_too_much(self) -> bool:
        """True if the image cannot be used. Spread dirt of the near road may also be in any other part."""
        return self.covered is None or self.share >= MAX_SHARE


class LensMonitor:
    """Monitors the lens of one camera that points ahead or back. The class is not thread-safe."""

    def __init__(self, rig: CameraRig) -> None:
        self._side = max(2 * (rig.width_px // (2 * SAMPLES_WIDE)), 1)
        self._shape = rig.height_px // self._side, rig.width_px // self._side
        self._first = min(_near_row(rig) // self._side, self._shape[0] - 3)
        self._horizon = max(round(_vanishing_px(rig)[1]) // (COARSE * self._side), 3)
        """First coarse row below the horizon."""
        self._near_edges = StaticEdges(*_motion_directions(rig, self._side, self._shape, self._first))
        flat = np.ones([cells // COARSE - 2 for cells in self._shape], np.float32)
        self._turn_edges = tuple(StaticEdges(flat, np.zeros_like(flat)) for _ in ("to the right", "to the left"))
        self._driven_from: PoseEstimate | None = None
        self._turned_from: PoseEstimate | None = None
        self._spread_dirt: LensDirt | None = None
        self._patch_dirt: LensDirt | None = None

    @property
    def dirt(self) -> LensDirt | None:
        """The known dirt; None without any."""
        return self._spread_dirt or self._patch_dirt

    def checked(self, frame: CameraFrame, pose: PoseEstimate | None, camera: str) -> tuple[CameraFrame | None, str]:
        """Examine an image. Return its usable form, or None, and the fault in a few words.

        Args:
            frame: The image.
            pose: The vehicle's pose at the image's time; None if the vehicle is stopped.
            camera: The camera's name.
        """
        if pose is not None:
            self.watch(frame.rgb, pose)
        dirt = self.dirt
        if dirt is None:
            return frame, ""
        reason = f"dirt on the lens touches {dirt.share:.1%} of the {camera}'s picture"
        return None if dirt.is_too_much else replace(frame, covered=dirt.covered), reason

    def watch(self, rgb: Pixels, pose: PoseEstimate) -> None:
        """Examine an image (height, width, 3) of the moving vehicle."""
        driven_from, turned_from = self._driven_from or pose, self._turned_from or pose
        driven_m = math.hypot(pose.x_m - driven_from.x_m, pose.y_m - driven_from.y_m)
        if driven_m >= MIN_DRIVEN_M and abs(_turn_rad(driven_from, pose)) <= STRAIGHT_PER_M * driven_m:
            self._near_edges.add(self._samples(rgb, self._first))
            self._spread_dirt = self._find_spread_dirt()
        turn_rad = _turn_rad(turned_from, pose)
        if abs(turn_rad) >= MIN_TURN_RAD:
            samples = _coarsened(self._samples(rgb, 0))
            sky = samples[: self._horizon]
            self._turn_edges[turn_rad > 0.0].add(sky if sky.mean() < NIGHT_BRIGHTNESS else samples)
            self._patch_dirt = self._find_patch_dirt()
            turned_from = pose
        self._driven_from, self._turned_from = (pose if driven_m >= MIN_DRIVEN_M else driven_from), turned_from

    def _samples(self, rgb: Pixels, first: int) -> Singles:
        """Return the green channel of an image from a row of samples on; each sample is the mean of four pixels."""
        if self._side == 1:
            return rgb[first:, :, 1].astype(np.float32)
        rows, columns = self._shape
        half = self._side // 2
        green = rgb[first * self._side :: half, ::half, 1][: 2 * (rows - first), : 2 * columns].astype(np.float32)
        pairs = green[::2] + green[1::2]
        return np.asarray(np.float32(0.25) * (pairs[:, ::2] + pairs[:, 1::2]))

    def _find_spread_dirt(self) -> LensDirt | None:
        """Return dirt that is spread over the width of the image, from the near road."""
        proof = self._near_edges.proving()
        wide = proof.shape[1] / SECTORS
        if _sector_share(proof) >= MIN_SPREAD and _sector_share(without_lines(proof, wide, LINE_SAMPLES)) >= MIN_SPREAD:
            return LensDirt(covered_by(self._near_edges.staying(), proof, MIN_GRAIN)[1], None)
        return (
            self._spread_dirt
            if self._spread_dirt and _sector_share(self._near_edges.proving(KNOWN_LENGTH)) >= MIN_SPREAD
            else None
        )

    def _find_patch_dirt(self) -> LensDirt | None:
        """Return dirt in any place, from the whole image in turns to both sides."""
        right, left = self._turn_edges
        proof = right.proving() & left.proving()
        if proof.sum() >= MIN_PATCH:
            covered, share = covered_by(right.staying() & left.staying(), proof, MIN_GRAIN)
            if (proof & covered).sum() >= MIN_PATCH:
                return LensDirt(share, np.pad(covered, 1))
        known_dirt = self._patch_dirt
        if known_dirt is None or known_dirt.covered is None:
            return None
        still_there = right.proving(KNOWN_LENGTH) & left.proving(KNOWN_LENGTH) & known_dirt.covered[1:-1, 1:-1]
        return known_dirt if still_there.sum() >= MIN_PATCH // 2 else None


def _vanishing_px(rig: CameraRig) -> tuple[float, float]:
    """Return column and row of the vanishing point of the vehicle's motion (px)."""
    ahead, left, up = rig.mount.to_vehicle()[0, :3]
    return rig.width_px / 2.0 - rig.focal_px * left / ahead, rig.height_px / 2.0 - rig.focal_px * up / ahead


def _near_row(rig: CameraRig) -> int:
    """Return the row in which a flat road is `NEAR_M` from the lens."""
    return max(round(_vanishing_px(rig)[1] + rig.focal_px * rig.mount.z_m / NEAR_M), 0)


def _motion_directions(rig: CameraRig, side: int, shape: tuple[int, int], first: int) -> tuple[Singles, Singles]:
    """Return the road's direction of motion, to the right and down, at all samples from a row on but the outermost."""
    y, x = side * (np.mgrid[first + 1 : shape[0] - 1, 1 : shape[1] - 1] + 0.5)
    column, row = _vanishing_px(rig)
    distance = np.maximum(np.hypot(x - column, y - row), 1.0)
    return ((x - column) / distance).astype(np.float32), ((y - row) / distance).astype(np.float32)


def _turn_rad(earlier: PoseEstimate, later: PoseEstimate) -> float:
    return math.remainder(later.yaw_rad - earlier.yaw_rad, math.tau)


def _coarsened(samples: Singles) -> Singles:
    rows, columns = samples.shape[0] // COARSE, samples.shape[1] // COARSE
    blocks = samples[: rows * COARSE, : columns * COARSE].reshape(rows, COARSE, columns, COARSE)
    return np.asarray(blocks.mean((1, 3)), np.float32)


def _sector_share(proof: Mask) -> float:
    """Return the share of proving samples in the sector with the `SPREAD_SECTORS`-th largest share."""
    shares = [float(part.mean()) for part in np.array_split(proof, SECTORS, axis=1)]
    return sorted(shares)[-SPREAD_SECTORS]
