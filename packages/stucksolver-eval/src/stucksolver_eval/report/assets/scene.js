// Draws one time of a run from above, in meters.

const SPEED_SCALE_MPS = 12;
const TRAIL_SHADES = 6;

function trace(path, line) {
  for (let i = 0; i < line.count; i += 1) {
    if (i) path.lineTo(line.x[i], line.y[i]);
    else path.moveTo(line.x[i], line.y[i]);
  }
}

function areaOf(lane) {
  const path = new Path2D();
  trace(path, lane.left);
  for (let i = lane.right.count - 1; i >= 0; i -= 1) path.lineTo(lane.right.x[i], lane.right.y[i]);
  path.closePath();
  return path;
}

function lineOf(line) {
  const path = new Path2D();
  trace(path, line);
  return path;
}

class Scene {
  constructor(run) {
    this.run = run;
    const rank = (lane) => LANE_ORDER.indexOf(LANE_ORDER.includes(lane.kind) ? lane.kind : "other");
    this.lanes = [...run.map.lanes].sort((a, b) => rank(a) - rank(b))
      .map((lane) => ({ kind: lane.kind, path: areaOf(lane) }));
    this.markings = run.map.markings.map((mark) => ({ ...mark, path: lineOf(mark.points) }));
    this.route = lineOf(run.route);
    this.paths = run.paths.map(([frame, line]) => [frame, line && lineOf(line)]);
    this.order = run.actors.map((_, index) => index).reverse();
  }

  draw(context, camera, frame) {
    this.drawRoad(context, camera);
    this.drawLines(context, camera, frame);
    this.drawLights(context, camera, frame);
    for (const index of this.order) {
      const pose = poseAt(this.run.tracks[index], frame);
      if (pose) drawActor(context, camera, this.run.actors[index], pose);
    }
  }

  drawRoad(context, camera) {
    context.lineJoin = "round";
    for (const lane of this.lanes) {
      context.fillStyle = context.strokeStyle = laneColour(lane.kind);
      context.lineWidth = camera.stroke(0, 0.8);
      context.fill(lane.path);
      context.stroke(lane.path);
    }
    for (const mark of this.markings) {
      context.setLineDash(mark.kind === "broken" ? [3, 3] : []);
      context.strokeStyle = markColour(mark);
      context.lineWidth = camera.stroke(mark.kind === "other" ? 0.1 : 0.14, mark.kind === "other" ? 0.8 : 1);
      context.stroke(mark.path);
    }
    context.setLineDash([]);
  }

  drawLines(context, camera, frame) {
    context.lineCap = "round";
    context.strokeStyle = colours().route;
    context.lineWidth = camera.stroke(1.3, 3);
    context.stroke(this.route);
    const path = stateAt(this.paths, frame);
    if (path) {
      context.strokeStyle = colours().recovery;
      context.lineWidth = camera.stroke(0.35, 2.4);
      context.setLineDash([1.6, 1.4]);
      context.stroke(path);
      context.setLineDash([]);
    }
    this.drawTrail(context, camera, frame);
    context.lineCap = "butt";
  }

  // The past path of the ego: dark where it was slow, in the ego's color where it was fast.
  drawTrail(context, camera, frame) {
    const spell = this.run.tracks[0] && this.run.tracks[0][0];
    if (!spell) return;
    const shades = Array.from({ length: TRAIL_SHADES }, () => new Path2D());
    const last = Math.min(Math.floor(frame), spell.last) - spell.first;
    for (let i = 1; i <= last; i += 1) {
      const part = Math.min(0.999, this.run.speed[spell.first + i] / SPEED_SCALE_MPS);
      const path = shades[Math.floor(part * TRAIL_SHADES)];
      path.moveTo(spell.x[i - 1], spell.y[i - 1]);
      path.lineTo(spell.x[i], spell.y[i]);
    }
    context.lineWidth = camera.stroke(0.3, 2);
    shades.forEach((path, index) => {
      context.strokeStyle = colours()[`trail-${index}`];
      context.stroke(path);
    });
  }

  drawLights(context, camera, frame) {
    for (const light of this.run.lights) {
      const state = stateAt(light.changes, frame);
      if (!state) continue;
      context.beginPath();
      context.arc(light.x, light.y, camera.stroke(0.7, 4), 0, 2 * Math.PI);
      context.fillStyle = colours()[`light-${state}`] || colours()["light-off"];
      context.strokeStyle = colours().ink;
      context.lineWidth = camera.stroke(0.15, 1.2);
      context.fill();
      context.stroke();
    }
  }
}

function markColour(mark) {
  if (mark.kind === "other") return colours().kerb;
  return mark.color === "yellow" ? colours()["mark-yellow"] : colours()["mark-white"];
}

function drawActor(context, camera, actor, pose) {
  const length = Math.max(actor.length_m, camera.stroke(0, 6));
  const width = Math.max(actor.width_m, camera.stroke(0, actor.role === "prop" ? 3 : 5));
  context.save();
  context.translate(pose.x, pose.y);
  context.rotate(pose.yaw);
  context.fillStyle = actorColour(actor);
  context.strokeStyle = actor.role === "ego" ? colours()["ego-edge"] : colours()["actor-edge"];
  context.lineWidth = camera.stroke(0.08, actor.role === "ego" ? 1.6 : 0.9);
  context.beginPath();
  if (actor.kind === "pedestrian" || actor.kind === "cone") {
    context.arc(0, 0, Math.max(width, length) / 2, 0, 2 * Math.PI);
  } else {
    context.roundRect(-length / 2, -width / 2, length, width, Math.min(width, length) * 0.22);
  }
  context.fill();
  context.stroke();
  if (actor.role !== "prop" && width * camera.scale > 6) drawHeading(context, length, width);
  context.restore();
}

// A light wedge in the actor's direction.
function drawHeading(context, length, width) {
  const tip = length * 0.42;
  const back = tip - Math.min(length * 0.3, width * 0.7);
  context.beginPath();
  context.moveTo(tip, 0);
  context.lineTo(back, width * 0.34);
  context.lineTo(back, -width * 0.34);
  context.closePath();
  context.fillStyle = colours().heading;
  context.fill();
}
