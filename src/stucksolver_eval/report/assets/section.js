// One scenario: its arms side by side, all on one slider.

const RATES = [0.5, 1, 2, 4, 8];

class Section {
  constructor(group) {
    this.group = group;
    const runs = group.runs;
    this.range = {
      start: Math.min(...runs.map((run) => run.start)),
      end: Math.max(...runs.map((run) => run.end)),
      top: Math.max(3, ...runs.map((run) => run.speed.reduce((a, b) => Math.max(a, b), 0))) * 1.08,
    };
    this.time = this.range.start;
    this.playing = false;
    this.rate = 2;
    const seek = (time) => this.seek(time);
    const seekFromRecords = (time) => this.seek(time, false);
    this.stages = runs.map((run) => new Stage(run));
    this.plots = runs.map((run) => new SpeedPlot(run, this.range, seek));
    this.records = runs.map((run) => new Records(run, seekFromRecords));
    this.element = h("section", { class: "replay", id: group.id }, this.header(), this.transport(),
      h("div", { class: "arms" }, runs.map((run, index) => this.arm(run, index))),
      legend(),
      h("div", { class: "logs" }, this.records.map((record) => record.element)));
    new ResizeObserver(() => this.refresh()).observe(this.element);
    new IntersectionObserver(([entry]) => {
      this.visible = entry.isIntersecting;
      this.refresh();
    }, { rootMargin: "200px" }).observe(this.element);
  }

  header() {
    const [run] = this.group.runs;
    return h("header", null, h("h2", null, capital(this.group.scenario)),
      h("p", { class: "key" }, `map ${run.map.name} · seed ${this.group.seed} · driver ${run.driver}`));
  }

  transport() {
    this.button = h("button", { type: "button", class: "play", onclick: () => this.toggle() }, "Play");
    this.slider = h("input", {
      type: "range", min: this.range.start, max: this.range.end, step: 0.05, value: this.time,
      "aria-label": "Time", oninput: () => this.seek(Number(this.slider.value)),
    });
    this.clock = h("output", { class: "clock" });
    const rates = h("select", { "aria-label": "Playback speed", onchange: () => { this.rate = Number(rates.value); } },
      RATES.map((rate) => h("option", { value: rate, selected: rate === this.rate }, `${rate}×`)));
    this.view = h("button", { type: "button", onclick: () => this.toggleView() }, "Whole route");
    return h("div", { class: "transport" }, this.button, this.slider, this.clock, rates, this.view);
  }

  arm(run, index) {
    return h("figure", { class: "arm" },
      h("figcaption", null, h("b", null, run.arm),
        h("span", { class: `tag ${statusTone(run.result.status)}` }, statusWords(run.result.status)),
        h("span", { class: "key" }, summary(run))),
      this.stages[index].element, this.plots[index].element);
  }

  toggle() {
    if (!this.playing && this.time >= this.range.end - 0.01) this.time = this.range.start;
    this.playing = !this.playing;
    this.button.textContent = this.playing ? "Pause" : "Play";
    this.last = null;
    if (this.playing) requestAnimationFrame((now) => this.tick(now));
  }

  toggleView() {
    const follow = !this.stages[0].camera.follow;
    for (const stage of this.stages) stage.camera.follow = follow;
    this.view.textContent = follow ? "Whole route" : "Follow ego";
    this.refresh();
  }

  tick(now) {
    if (!this.playing) return;
    if (this.last !== null) this.time += (Math.min(now - this.last, 250) / 1000) * this.rate;
    this.last = now;
    if (this.time >= this.range.end) {
      this.time = this.range.end;
      this.toggle();
    }
    this.draw();
    if (this.playing) requestAnimationFrame((next) => this.tick(next));
  }

  // `scroll` brings the decision of that time into view in its list; whoever clicked there sees it already.
  seek(time, scroll = true) {
    this.scroll = scroll;
    this.time = Math.min(this.range.end, Math.max(this.range.start, time));
    this.refresh();
  }

  // Draws once before the next screen refresh, however often it is asked for.
  refresh() {
    if (this.pending || (this.drawn && !this.visible)) return;
    this.pending = this.drawn = true;
    requestAnimationFrame(() => {
      this.pending = false;
      this.draw();
    });
  }

  draw() {
    this.slider.value = this.time;
    this.clock.textContent = `${this.time.toFixed(1)} / ${seconds(this.range.end)}`;
    for (const part of [...this.stages, ...this.plots]) part.draw(this.time);
    for (const record of this.records) record.draw(this.time, this.playing || this.scroll);
  }
}

function summary({ result }) {
  const recovered = result.time_to_recover_s === null ? "" : ` · recovered in ${seconds(result.time_to_recover_s)}`;
  return `route ${figure(result.route_completion_pct, 0)} % · stopped ${seconds(result.stopped_s)}${recovered}`;
}

function legend() {
  const entries = [
    ["ego", "ego"], ["scenario", "part of the scenario"], ["traffic", "other traffic"],
    ["vulnerable", "people, two-wheelers"], ["object", "objects"], ["route line", "route"],
    ["trail line", "driven (orange: slow)"], ["recovery line", "recovery path"], ["stuck", "immobilized"],
    ["moment good", "plan accepted"], ["moment bad", "plan refused"], ["moment idle", "nothing to do"],
    ["guidance dot", "passenger speaks"],
  ];
  return h("ul", { class: "legend" },
    entries.map(([kind, name]) => h("li", null, h("span", { class: `key-mark ${kind}` }), name)));
}
