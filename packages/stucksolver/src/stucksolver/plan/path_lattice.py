"""Finds the cheapest motion of an axle on a lattice of offsets, slopes and curvatures, layer by layer.

With layers `LAYER_M` apart, offsets, slopes and curvatures are multiples of one quantum each, and a step from cell to
cell is exact: the slope grows by the curvature, and the offset by the slope. So every motion keeps the turning radius,
and a whole layer is one shift of an array.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from stucksolver.plan.swept_body import Body, Borders, Obstacles, blocked_offsets
from stucksolver.scene.frenet import Array

LAYER_M = 1.0
"""Distance between two layers (m). Ours."""
BENDS = 2
"""Curvature levels from straight to full lock on each side. Ours."""
STEEPEST = 1.0
"""Steepest slope of the axle's path to the road: 45 degrees. Ours."""
BEND_COST, STEER_COST = 1.0, 0.6
"""Cost of a meter at full lock, and of turning the wheels from straight to full lock. Ours."""
ASIDE_COST = 0.06
"""Cost of a meter driven a meter beside the goal. Ours."""
NEAR_COST = 8.0
"""Cost of a meter at the least clearance; it falls to zero at the desired clearance. Ours."""
NEAR_PARTS = (1.0, 0.7, 0.45, 0.25, 0.1)
"""Parts of the way from the least to the desired clearance at which the cost changes. Ours."""
SHORT_COST = 1e4
"""Cost of a layer below the least clearance. It exceeds that of every path that keeps the clearance."""
SHORT_M = (0.0, 0.1, 0.2, 0.35, 0.5, 0.75, 1.0, 1.5)
"""Lacks of clearance at which `SHORT_COST` is due again, so that the path lacks as little as possible (m). Ours."""
BEYOND_LAYERS = 2
"""Layers straight on beyond the goal whose cost counts. Ours."""
BACK_COST = 30.0
"""Cost of a meter that the ego backs up before it starts. Ours."""
STRAIGHTENS_M = 3.0
"""Distance over which the body becomes straight while it backs up (m): `TrackingPolicy.straightens_m`."""


@dataclass(frozen=True)
class LatticeMotion:
    """Cheapest motion of the axle.

    Attributes:
        s, d: (layers,): arc lengths and offsets of the axle (m), from the start to the goal.
        back_m: Distance by which the start was moved back (m).
        cost: Cost; at least `SHORT_COST` if a clearance is not kept.
    """

    s: Array
    d: Array
    back_m: float
    cost: float

    @property
    def clear(self) -> bool:
        """True if the motion keeps all clearances."""
        return self.cost < SHORT_COST


@dataclass(frozen=True)
class LatticeTask:
    """Start and goal of the axle, with what limits its motion.

    Attributes:
        body: Body of the ego.
        start_s, start_d: Arc length and offset at the start (m).
        slope: Slope of the axle's path to the road at the start.
        goal_d: Offset at the goal (m), where the slope is zero.
        earliest_s, latest_s: Arc lengths between which the goal must be reached (m).
        radius_m: Smallest turning radius (m).
        back_m: Greatest distance by which the start may be moved back (m).
        least_back_m: Least such distance (m).
    """

    body: Body
    start_s: float
    start_d: float
    slope: float
    goal_d: float
    earliest_s: float
    latest_s: float
    radius_m: float
    back_m: float = 0.0
    least_back_m: float = 0.0


def cheapest_motion(
    task: LatticeTask, borders: Borders, obstacles: Obstacles, road_bend: Array
) -> LatticeMotion | None:
    """Return the cheapest motion to the goal; None if the borders allow none.

    Args:
        task: Start and goal.
        borders: Borders for the body.
        obstacles: Objects to keep clear of.
        road_bend: Curvatures of the road (1/m) and their arc lengths (m), shape (2, stations).
    """
    lattice = _Lattice(task, borders)
    if lattice.layers < 2 or not 0 <= lattice.goal_cell < lattice.cells:
        return None
    stage = lattice.stage_costs(task, borders, obstacles)
    return lattice.search(stage, lattice.bend_costs(road_bend), task)


@lru_cache(maxsize=32)
def _sources(slopes: int, cells: int) -> NDArray[np.intp]:
    """(bends, slopes, cells): index of the cell from which each cell is reached; the last index + 1 for none."""
    bend, slope, cell = np.meshgrid(
        np.arange(-BENDS, BENDS + 1), np.arange(-slopes, slopes + 1), np.arange(cells), indexing="ij"
    )
    from_slope, from_cell = slope - bend, cell - slope
    inside = (np.abs(from_slope) <= slopes) & (from_cell >= 0) & (from_cell < cells)
    index = ((bend + BENDS) * (2 * slopes + 1) + from_slope + slopes) * cells + from_cell
    result: NDArray[np.intp] = np.where(inside, index, bend.size)
    return result


class _Lattice:
    """Cells of one task: (curvatures, slopes, offsets) in each layer."""

    def __init__(self, task: LatticeTask, borders: Borders) -> None:
        self.slope_step = LAYER_M / (BENDS * task.radius_m)
        self.cell_m = LAYER_M * self.slope_step
        self.slopes = int(STEEPEST / self.slope_step)
        self.behind = round(task.back_m / LAYER_M)
        self.last_start = self.behind - round(task.least_back_m / LAYER_M)
        ahead = int((task.latest_s - task.start_s) / LAYER_M + 1e-6)
        self.layers = max(self.behind + ahead + 1, 0)
        self.s: Array = task.start_s + LAYER_M * (np.arange(self.layers) - self.behind)
        near = (borders.s >= task.start_s - 10.0) & (borders.s <= task.latest_s + 10.0)
        low = min(float(borders.right[near].min(initial=np.inf)), task.start_d, task.goal_d)
        high = max(float(borders.left[near].max(initial=-np.inf)), task.start_d, task.goal_d)
        self.first = int(np.floor((low - task.start_d) / self.cell_m)) - 1
        self.cells = int(np.ceil((high - task.start_d) / self.cell_m)) + 2 - self.first
        self.d: Array = task.start_d + self.cell_m * (np.arange(self.cells) + self.first)
        self.goal_cell = round((task.goal_d - task.start_d) / self.cell_m) - self.first
        back_m = LAYER_M * np.arange(self.behind, -1, -1)
        tilts = np.rint(task.slope * np.exp(-back_m / STRAIGHTENS_M) / self.slope_step).astype(int)
        self.start_slopes: list[int] = (np.clip(tilts, -self.slopes, self.slopes) + self.slopes).tolist()
        self.yaw: Array = np.arctan(self.slope_step * np.arange(-self.slopes, self.slopes + 1))

    def stage_costs(self, task: LatticeTask, borders: Borders, obstacles: Obstacles) -> Array:
        """(layers, slopes, offsets): cost of being in a cell; infinite beyond the borders."""
        low, high = borders.offsets(task.body, self.s[:, None], self.yaw)
        width = len(self.yaw) * (self.cells + 1)
        changes = self._object_costs(task.body, obstacles, width)
        stage: Array = np.cumsum(changes.reshape(self.layers, len(self.yaw), self.cells + 1), axis=-1)[..., :-1]
        stage += ASIDE_COST * LAYER_M * np.abs(self.d - task.goal_d)
        stage[(self.d < low[..., None]) | (self.d > high[..., None])] = np.inf
        return stage.astype(np.float32)

    def _object_costs(self, body: Body, obstacles: Obstacles, width: int) -> Array:
        """Return the changes of the cost from offset to offset due to the objects, flat."""
        size = self.layers * width
        far = np.hypot(obstacles.half_length, obstacles.half_width) + obstacles.desired + body.half_length_m
        layer, member = np.nonzero(np.abs(obstacles.s - self.s[:, None]) < far + abs(body.lever_m))
        if not len(layer):
            return np.zeros(size)
        there = obstacles.some(member).columns()
        steps, costs = _clearance_steps(there.least, there.desired)
        low, high = blocked_offsets(body, self.s[layer][:, None], self.yaw, there, steps)
        first = np.clip(np.ceil((low - self.d[0]) / self.cell_m), 0, self.cells).astype(np.intp)
        last = np.clip(np.floor((high - self.d[0]) / self.cell_m) + 1, 0, self.cells).astype(np.intp)
        row = layer[:, None] * width + np.arange(len(self.yaw)) * (self.cells + 1)
        weight = np.broadcast_to(np.where(first < last, costs[:, None, None], 0.0), first.shape).ravel()
        begins = np.bincount((row + first).ravel(), weight, size)
        result: Array = begins - np.bincount((row + last).ravel(), weight, size)
        return result

    def bend_costs(self, road_bend: Array) -> Array:
        """(layers, bends): cost of a meter at each curvature; infinite where the road's own curvature leaves none."""
        bends = np.arange(-BENDS, BENDS + 1) / BENDS
        most = self.slope_step * BENDS / LAYER_M
        road = np.interp(self.s, road_bend[0], road_bend[1])[:, None]
        cost = np.broadcast_to(BEND_COST * LAYER_M * bends**2, (self.layers, len(bends))).copy()
        cost[np.abs(bends * most + road) > np.maximum(most, np.abs(road)) + 1e-9] = np.inf
        result: Array = cost.astype(np.float32)
        return result

    def search(self, stage: Array, bend: Array, task: LatticeTask) -> LatticeMotion | None:
        """Return the cheapest motion through the layers; None without one."""
        shape = (2 * BENDS + 1, len(self.yaw), self.cells)
        source = _sources(self.slopes, self.cells)
        cost = np.full(shape, np.inf, dtype=np.float32)
        flat = np.full(cost.size + 1, np.inf, dtype=np.float32)
        steered = np.zeros((self.layers, *shape), dtype=np.int8)
        best, goal = np.inf, (BENDS, self.slopes, self.goal_cell)
        beyond = self._costs_beyond(stage)
        reached = -1
        for layer in range(self.layers):
            if layer:
                flat[:-1] = _steer(cost, steered[layer]).ravel()
                cost = flat[source] + stage[layer] + bend[layer][:, None, None]
            if layer <= self.last_start:
                cell = (BENDS, self.start_slopes[layer], -self.first)
                seed = BACK_COST * LAYER_M * (self.behind - layer)
                cost[cell] = min(float(cost[cell]), seed)
            there = float(cost[goal] + beyond[layer])
            if layer > self.last_start and there < best and self.s[layer] >= task.earliest_s:
                best, reached = there, layer
        return None if reached < 0 else self._trace(steered, reached, best)

    def _costs_beyond(self, stage: Array) -> Array:
        """(layers,): cost of driving straight on from the goal in each layer, for `BEYOND_LAYERS` layers."""
        straight = np.concatenate([stage[:, self.slopes, self.goal_cell], np.zeros(BEYOND_LAYERS)])
        moved = [straight[k : k + self.layers] for k in range(1, BEYOND_LAYERS + 1)]
        result: Array = np.sum(moved, axis=0)
        return result

    def _trace(self, steered: NDArray[np.int8], reached: int, cost: float) -> LatticeMotion:
        """Return the motion that ends at the goal in the layer `reached`."""
        bend, slope, cell = BENDS, self.slopes, self.goal_cell
        offsets = [float(self.d[cell])]
        layer = reached
        while layer > 0 and not self._starts(layer, bend, slope, cell):
            slope, cell = slope - (bend - BENDS), cell - (slope - self.slopes)
            bend += int(steered[layer, bend, slope, cell])
            offsets.append(float(self.d[cell]))
            layer -= 1
        back_m = LAYER_M * (self.behind - layer)
        return LatticeMotion(self.s[layer : reached + 1], np.array(offsets[::-1]), back_m, cost - BACK_COST * back_m)

    def _starts(self, layer: int, bend: int, slope: int, cell: int) -> bool:
        """True if the motion starts in this cell of a layer."""
        return layer <= self.last_start and (bend, slope, cell) == (BENDS, self.start_slopes[layer], -self.first)


def _clearance_steps(least: Array, desired: Array) -> tuple[Array, Array]:
    """Return clearances (steps, objects, 1) (m) and the cost (steps,) of a layer below each of them."""
    near = [least + part * (desired - least) for part in NEAR_PARTS]
    short = [least - lack for lack in SHORT_M]
    costs = [NEAR_COST * LAYER_M / len(NEAR_PARTS)] * len(NEAR_PARTS) + [SHORT_COST] * len(SHORT_M)
    return np.stack(near + short), np.array(costs)


def _steer(cost: Array, change: NDArray[np.int8]) -> Array:
    """Return the cheapest cost of each cell after turning the wheels, and write the change of curvature before it."""
    best: Array = cost.copy()
    for step in (-1, 1):
        to, by = (slice(None, -step), slice(step, None)) if step > 0 else (slice(-step, None), slice(None, step))
        turned = cost[by] + np.float32(STEER_COST * (step / BENDS) ** 2)
        cheaper = turned < best[to]
        np.copyto(best[to], turned, where=cheaper)
        np.copyto(change[to], step, where=cheaper)
    return best
