// Maps meters on the map to pixels. The map is turned so that the route runs along the wide side: the whole route in
// the whole view, and the part around the ego while following.

const FOLLOW_HEIGHT_M = 18;
const FOLLOW_WIDTH_M = 54;
const NARROW_PX = 480;
const NARROW_WIDTH_M = 36;
const MARGIN_M = 14;
const AHEAD_M = 8;
const AROUND_M = 20;

function extent(line, angle) {
  let [u0, u1, v0, v1] = [Infinity, -Infinity, Infinity, -Infinity];
  for (let i = 0; i < line.count; i += 1) {
    const u = line.x[i] * Math.cos(angle) + line.y[i] * Math.sin(angle);
    const v = line.y[i] * Math.cos(angle) - line.x[i] * Math.sin(angle);
    [u0, u1, v0, v1] = [Math.min(u0, u), Math.max(u1, u), Math.min(v0, v), Math.max(v1, v)];
  }
  return { u: (u0 + u1) / 2, v: (v0 + v1) / 2, width: u1 - u0, height: v1 - v0 };
}

// Returns the rotation of the map that makes the route flattest, with its start on the left.
function flattest(line) {
  let best = { angle: 0, height: Infinity };
  for (let degrees = 0; degrees < 180; degrees += 3) {
    const angle = (degrees * Math.PI) / 180;
    const { height } = extent(line, angle);
    if (height < best.height - 0.01) best = { angle, height };
  }
  const last = line.count - 1;
  const along = (line.x[last] - line.x[0]) * Math.cos(best.angle)
    + (line.y[last] - line.y[0]) * Math.sin(best.angle);
  return along < 0 ? best.angle + Math.PI : best.angle;
}

// Returns the route's direction around a point, smoothed so that the view turns calmly.
function directionAround(line, x, y, otherwise) {
  const away = (i, px, py) => Math.hypot(line.x[i] - px, line.y[i] - py);
  let nearest = 0;
  for (let i = 1; i < line.count; i += 1) if (away(i, x, y) < away(nearest, x, y)) nearest = i;
  let [back, ahead] = [nearest, nearest];
  while (back > 0 && away(back, line.x[nearest], line.y[nearest]) < AROUND_M) back -= 1;
  while (ahead < line.count - 1 && away(ahead, line.x[nearest], line.y[nearest]) < AROUND_M) ahead += 1;
  const [dx, dy] = [line.x[ahead] - line.x[back], line.y[ahead] - line.y[back]];
  return dx || dy ? Math.atan2(dy, dx) : otherwise;
}

class Camera {
  constructor(route) {
    this.line = route;
    this.wholeAngle = route.count ? flattest(route) : 0;
    this.route = route.count ? extent(route, this.wholeAngle) : { u: 0, v: 0, width: 100, height: 40 };
    this.follow = true;
  }

  // Sets the visible part: `pose` is the ego's, width and height are in pixels.
  aim(pose, width, height) {
    this.width = width;
    this.height = height;
    if (this.follow && pose) {
      this.angle = directionAround(this.line, pose.x, pose.y, pose.yaw);
      const along = width < NARROW_PX ? NARROW_WIDTH_M : FOLLOW_WIDTH_M;
      this.scale = Math.min(width / along, height / FOLLOW_HEIGHT_M);
      this.x = pose.x + AHEAD_M * Math.cos(pose.yaw);
      this.y = pose.y + AHEAD_M * Math.sin(pose.yaw);
      return;
    }
    this.angle = this.wholeAngle;
    const [cos, sin] = [Math.cos(this.angle), Math.sin(this.angle)];
    this.scale = Math.min(width / (this.route.width + 2 * MARGIN_M), height / (this.route.height + 2 * MARGIN_M));
    this.x = this.route.u * cos - this.route.v * sin;
    this.y = this.route.u * sin + this.route.v * cos;
  }

  // Makes the canvas draw in meters; `ratio` is the number of device pixels per CSS pixel.
  apply(context, ratio) {
    const k = this.scale * ratio;
    const [cos, sin] = [k * Math.cos(this.angle), k * Math.sin(this.angle)];
    context.setTransform(
      cos, sin, sin, -cos,
      (this.width * ratio) / 2 - cos * this.x - sin * this.y,
      (this.height * ratio) / 2 - sin * this.x + cos * this.y,
    );
  }

  // Returns the CSS pixels of a point.
  project(x, y) {
    const [cos, sin] = [Math.cos(this.angle), Math.sin(this.angle)];
    const [dx, dy] = [x - this.x, y - this.y];
    return [
      this.width / 2 + this.scale * (cos * dx + sin * dy),
      this.height / 2 + this.scale * (sin * dx - cos * dy),
    ];
  }

  // Returns the length that looks `pixels` wide (m), but at least `metres`.
  stroke(metres, pixels) {
    return Math.max(metres, pixels / this.scale);
  }
}
