// The view from above, drawn live with the scripts that draw a report's replays.

/* global Scene, Camera, colours, onSchemeChange */

const TRAIL = 4000;

const line = (points) => ({
  count: points.length,
  x: points.map(([x]) => x),
  y: points.map(([, y]) => y),
});

export const canDraw = () => typeof Scene !== "undefined" && typeof Camera !== "undefined";

export class View {
  constructor(canvas) {
    this.canvas = canvas;
    this.run = null;
    onSchemeChange(() => this.draw());
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  // The static part. It starts a new drive.
  scenery(told) {
    this.run = {
      map: {
        lanes: told.lanes.map((lane) => ({ kind: lane.kind, left: line(lane.left), right: line(lane.right) })),
        markings: told.markings.map((mark) => ({ ...mark, points: line(mark.points) })),
      },
      route: line(told.route),
      actors: [{ kind: "car", role: "ego", length_m: 4.9, width_m: 1.9 }],
      tracks: [[{ first: 0, last: -1, x: [], y: [], yaw: [] }]],
      paths: [],
      lights: [],
      speed: [],
    };
    this.scene = new Scene(this.run);
    this.camera = new Camera(this.run.route);
    this.frame = -1;
    this.path = "";
  }

  // The moving part. Other road users exist in this one frame only; the car's own path is stored for its trail.
  show(told) {
    if (!this.run) return;
    const { run } = this;
    const [own] = run.tracks[0];
    if (own.x.length > TRAIL) this.forget(own);
    this.frame = own.x.length;
    run.actors.length = 1;
    run.tracks.length = 1;
    for (const [index, kind, role, length_m, width_m, x, y, degrees] of told.actors) {
      const yaw = (degrees * Math.PI) / 180;
      if (index === 0) {
        own.x.push(x);
        own.y.push(y);
        own.yaw.push(yaw);
        run.speed.push(told.speed);
        run.actors[0] = { kind, role, length_m, width_m };
      } else {
        run.actors.push({ kind, role, length_m, width_m });
        run.tracks.push([{ first: this.frame, last: this.frame, x: [x], y: [y], yaw: [yaw] }]);
      }
    }
    own.last = own.x.length - 1;
    run.lights = told.lights.map(([x, y, state]) => ({ x, y, changes: [[0, state]] }));
    this.scene.order = run.actors.map((_, index) => index).reverse();
    this.follow(told.path);
    this.draw();
  }

  forget(own) {
    for (const values of [own.x, own.y, own.yaw, this.run.speed]) values.splice(0, TRAIL / 2);
  }

  follow(path) {
    const key = JSON.stringify(path[0] || "") + path.length;
    if (key === this.path) return;
    this.path = key;
    const drawn = new Path2D();
    path.forEach(([x, y], i) => (i ? drawn.lineTo(x, y) : drawn.moveTo(x, y)));
    this.scene.paths = path.length ? [[0, drawn]] : [];
  }

  draw() {
    if (!this.run || this.frame < 0) return;
    const own = this.run.tracks[0][0];
    const at = own.x.length - 1;
    const pose = { x: own.x[at], y: own.y[at], yaw: own.yaw[at] };
    const ratio = Math.min(devicePixelRatio || 1, 2);
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
    if (this.canvas.width !== w) this.canvas.width = w;
    if (this.canvas.height !== h) this.canvas.height = h;
    const context = this.canvas.getContext("2d");
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.fillStyle = colours().ground;
    context.fillRect(0, 0, w, h);
    this.camera.aim(pose, width, height);
    this.camera.apply(context, ratio);
    this.scene.draw(context, this.camera, this.frame);
  }
}
