// Speed over time: immobilized spans are shaded, decisions and the passenger's utterances marked, and the cursor
// follows the slider.

const PLOT_HEIGHT = 128;
const EDGE = { left: 30, right: 8, top: 20, bottom: 20 };

class SpeedPlot {
  constructor(run, range, seek) {
    Object.assign(this, { run, range, seek });
    this.element = h("div", { class: "plot" });
    this.cursor = s("line", { class: "cursor", y1: EDGE.top - 6, y2: PLOT_HEIGHT - EDGE.bottom });
    this.element.addEventListener("pointerdown", (event) => {
      this.element.setPointerCapture(event.pointerId);
      this.point(event);
    });
    this.element.addEventListener("pointermove", (event) => event.buttons && this.point(event));
    new ResizeObserver(() => this.layout()).observe(this.element);
  }

  x(time) {
    const inner = this.width - EDGE.left - EDGE.right;
    return EDGE.left + (inner * (time - this.range.start)) / Math.max(this.range.end - this.range.start, 0.1);
  }

  y(speed) {
    return PLOT_HEIGHT - EDGE.bottom - ((PLOT_HEIGHT - EDGE.top - EDGE.bottom) * speed) / this.range.top;
  }

  point(event) {
    const inner = this.width - EDGE.left - EDGE.right;
    const part = (event.clientX - this.element.getBoundingClientRect().left - EDGE.left) / inner;
    this.seek(this.range.start + Math.min(1, Math.max(0, part)) * (this.range.end - this.range.start));
  }

  layout() {
    this.width = this.element.clientWidth;
    if (!this.width) return;
    this.element.replaceChildren(s("svg", {
      width: this.width, height: PLOT_HEIGHT, role: "img", "aria-label": `Speed over time: ${this.run.arm}`,
    }, this.spans(), this.axes(), this.curve(), this.marks(), this.cursor));
    this.draw(this.time || this.range.start);
  }

  spans() {
    return this.run.stuck.map(([from, to]) => s("rect", {
      class: "stuck", x: this.x(from), width: Math.max(1, this.x(to) - this.x(from)),
      y: EDGE.top, height: PLOT_HEIGHT - EDGE.top - EDGE.bottom,
    }, s("title", null, `immobilized ${seconds(from)} to ${seconds(to)}`)));
  }

  axes() {
    const bottom = PLOT_HEIGHT - EDGE.bottom;
    const parts = [s("text", { class: "label", x: 2, y: 11 }, "m/s")];
    for (const speed of ticks(this.range.top, 3)) {
      const [x1, x2, y] = [EDGE.left, this.width - EDGE.right, this.y(speed)];
      parts.push(s("line", { class: "grid", x1, x2, y1: y, y2: y }));
      parts.push(s("text", { class: "label", x: EDGE.left - 5, y: this.y(speed) + 4, "text-anchor": "end" }, speed));
    }
    const count = Math.max(2, Math.floor(this.width / 70));
    for (const time of ticks(this.range.end, count).filter((tick) => tick >= this.range.start)) {
      const anchor = this.x(time) > this.width - 20 ? "end" : "middle";
      parts.push(s("text", { class: "label", x: this.x(time), y: bottom + 14, "text-anchor": anchor }, `${time} s`));
    }
    return parts;
  }

  curve() {
    const { time, speed } = this.run;
    const points = [];
    for (let i = 0; i < time.length; i += 1) {
      points.push(`${this.x(time[i]).toFixed(1)},${this.y(speed[i]).toFixed(1)}`);
    }
    return s("polyline", { class: "speed", points: points.join(" ") });
  }

  marks() {
    const decisions = this.run.decisions.map((moment) => {
      const [x, tone] = [this.x(moment.time_s), outcomeTone(moment.outcome)];
      return s("path", { class: `moment ${tone}`, d: tone === "idle" ? `M${x} 7v6` : `M${x - 4.5} 5h9l-4.5 8z` },
        s("title", null, `${seconds(moment.time_s)}: decision, ${moment.verdict}`));
    });
    const events = this.run.events.filter((event) => ["guidance", "infraction", "abort"].includes(event.kind));
    return [decisions, events.map((event) => s("circle", {
      class: `event ${event.kind}`, cx: this.x(event.time_s), cy: PLOT_HEIGHT - EDGE.bottom, r: 4,
    }, s("title", null, `${seconds(event.time_s)}: ${event.kind}: ${event.text}`)))];
  }

  draw(time) {
    this.time = time;
    if (!this.width) return;
    const x = this.x(time);
    this.cursor.setAttribute("x1", x);
    this.cursor.setAttribute("x2", x);
  }
}

// Returns about `count` round values from 0 to `top`.
function ticks(top, count) {
  const rough = top / count;
  const power = 10 ** Math.floor(Math.log10(Math.max(rough, 1e-6)));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((value) => value >= rough);
  const values = [];
  for (let value = 0; value <= top + 1e-9; value += step) values.push(Number(value.toFixed(6)));
  return values;
}
