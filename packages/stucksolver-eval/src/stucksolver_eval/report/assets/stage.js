// Replay of one system: the canvas, the text over it, and the passenger's utterances at their time.

const BUBBLE_S = 6;
const CAPTION_S = 4;
const SCALE_BARS_M = [5, 10, 20, 50, 100, 200, 500];

class Stage {
  constructor(run) {
    this.run = run;
    this.camera = new Camera(run.route);
    this.canvas = h("canvas", { role: "img", "aria-label": `Bird's-eye replay: ${run.arm}` });
    this.speed = h("span", { class: "chip" });
    this.stuck = h("span", { class: "chip warn" }, "immobilized");
    this.recovering = h("span", { class: "chip recovery" }, "recovery manoeuvre");
    this.ended = h("span", { class: "chip" });
    this.caption = h("div", { class: "caption" }, h("span"));
    this.bubble = h("div", { class: "bubble" }, h("p"));
    this.name = h("div", { class: "name", hidden: true });
    this.stage = h("div", { class: "stage" }, this.canvas,
      h("div", { class: "chips" }, this.speed, this.stuck, this.recovering, this.ended, this.caption),
      this.bubble, this.name);
    this.element = h("div", { class: "stage-box" }, this.stage);
    this.stage.addEventListener("pointermove", (event) => this.nameAt(event.offsetX, event.offsetY));
    this.stage.addEventListener("pointerleave", () => { this.name.hidden = true; });
  }

  draw(time) {
    this.time = time;
    this.scene = this.scene || new Scene(this.run);
    const frame = frameAt(this.run, time);
    const pose = poseAt(this.run.tracks[0] || [], frame);
    const ratio = Math.min(devicePixelRatio || 1, 2);
    const { clientWidth: width, clientHeight: height } = this.stage;
    const [w, hgt] = [Math.round(width * ratio), Math.round(height * ratio)];
    if (this.canvas.width !== w) this.canvas.width = w;
    if (this.canvas.height !== hgt) this.canvas.height = hgt;
    const context = this.canvas.getContext("2d");
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.fillStyle = colours().ground;
    context.fillRect(0, 0, w, hgt);
    this.camera.aim(pose, width, height);
    this.camera.apply(context, ratio);
    this.scene.draw(context, this.camera, frame);
    this.drawScale(context, ratio);
    this.write(time, frame, pose);
  }

  drawScale(context, ratio) {
    const metres = SCALE_BARS_M.find((bar) => bar * this.camera.scale > 46) || 500;
    const length = metres * this.camera.scale;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    const [x, y] = [this.camera.width - length - 12, this.camera.height - 10];
    context.strokeStyle = context.fillStyle = colours().muted;
    context.lineWidth = 1.5;
    context.beginPath();
    context.moveTo(x, y - 4);
    context.lineTo(x, y);
    context.lineTo(x + length, y);
    context.lineTo(x + length, y - 4);
    context.stroke();
    context.font = "11px system-ui, sans-serif";
    context.textAlign = "center";
    context.fillText(`${metres} m`, x + length / 2, y - 5);
  }

  write(time, frame, pose) {
    const { run } = this;
    this.speed.textContent = `${rounded(run.speed[Math.floor(frame)] || 0, 1)} m/s`;
    this.stuck.hidden = !during(run.stuck, time);
    this.recovering.hidden = !stateAt(run.paths, frame);
    this.ended.hidden = time <= run.end;
    this.ended.textContent = `${statusWords(run.ended)} at ${seconds(run.end)}`;
    this.say(this.caption, latest(run.events, time, CAPTION_S, (event) => event.kind !== "guidance"));
    this.say(this.bubble, latest(run.events, time, BUBBLE_S, (event) => event.kind === "guidance"));
    if (pose && !this.bubble.hidden) {
      const [x, y] = this.camera.project(pose.x, pose.y);
      this.bubble.classList.toggle("above", y + 14 > this.camera.height - this.bubble.offsetHeight);
      const half = this.bubble.offsetWidth / 2;
      const left = Math.min(Math.max(x - half, 8), this.camera.width - 2 * half - 8);
      this.bubble.style.left = `${left}px`;
      this.bubble.style.setProperty("--tail", `${Math.min(Math.max(x - left, 14), 2 * half - 14)}px`);
    }
  }

  // Names the actor under the pointer.
  nameAt(x, y) {
    const frame = frameAt(this.run, this.time);
    const found = this.run.actors.findIndex((actor, index) => {
      const pose = poseAt(this.run.tracks[index], frame);
      if (!pose) return false;
      const [px, py] = this.camera.project(pose.x, pose.y);
      return Math.hypot(px - x, py - y) < Math.max(9, (actor.length_m / 2) * this.camera.scale);
    });
    this.name.hidden = found < 0;
    if (found < 0) return;
    const { label, kind } = this.run.actors[found];
    this.name.textContent = label === kind ? label : `${label} (${words(kind)})`;
    this.name.style.left = `${x}px`;
    this.name.style.top = `${y - 10}px`;
  }

  say(element, event) {
    element.hidden = !event;
    if (event) element.firstChild.textContent = element === this.bubble ? `“${event.text}”` : event.text;
  }
}

function latest(events, time, for_s, wanted) {
  return events.findLast((event) => event.time_s <= time && time < event.time_s + for_s && wanted(event));
}
