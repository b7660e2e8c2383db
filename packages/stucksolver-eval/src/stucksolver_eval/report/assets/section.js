// One scenario: its systems side by side, all on one slider.

const RATES = [0.5, 1, 2, 4, 8];
const STEP_S = 0.05;
const LONG_STEP_S = 1;

class Section {
  constructor(group) {
    this.group = group;
    const runs = group.runs;
    this.range = {
      start: Math.min(...runs.map((run) => run.start)),
      end: Math.max(...runs.map((run) => run.end)),
      top: Math.max(3, ...runs.map((run) => run.speed.reduce((a, b) => Math.max(a, b), 0))) * 1.08,
    };
    this.drives = runs.some((run) => run.time.length);
    this.time = this.range.start;
    this.playing = false;
    this.rate = 2;
    const seek = (time) => this.seek(time);
    const seekFromRecords = (time) => this.seek(time, false);
    this.stages = runs.map((run) => new Stage(run));
    this.plots = runs.map((run) => new SpeedPlot(run, this.range, seek));
    this.records = runs.map((run) => new Records(run, seekFromRecords));
    this.element = h("section", { class: "replay", id: group.id, "aria-labelledby": `${group.id}-name` },
      this.header(), this.drives ? this.replay() : null,
      h("div", { class: "logs" }, this.records.map((record) => record.element)));
    new ResizeObserver(() => this.refresh()).observe(this.element);
    new IntersectionObserver(([entry]) => {
      this.visible = entry.isIntersecting;
      this.refresh();
    }, { rootMargin: "200px" }).observe(this.element);
  }

  header() {
    const [run] = this.group.runs;
    return h("header", null, h("h2", { id: `${this.group.id}-name` }, capital(this.group.scenario)),
      h("p", { class: "key" }, `map ${run.map.name} · seed ${this.group.seed} · driver ${run.driver}`));
  }

  // Controls, views from above and their legend. The controls stay visible until all of them are scrolled away.
  replay() {
    return [this.transport(), h("div", { class: "arms" }, this.group.runs.map((run, index) => this.arm(run, index))),
      legend()];
  }

  transport() {
    this.button = h("button", { type: "button", class: "play", onclick: () => this.toggle() }, "Play");
    this.slider = h("input", {
      type: "range", min: this.range.start, max: this.range.end, step: STEP_S, value: this.time,
      "aria-label": `Time, ${this.group.scenario}`, "aria-keyshortcuts": "Space ArrowLeft ArrowRight",
      title: "Space plays and pauses; the arrow keys step by 0.05 s, with Shift by 1 s",
      oninput: () => this.seek(Number(this.slider.value)),
    });
    this.clock = h("output", { class: "clock" });
    const rates = h("select", { "aria-label": `Playback speed, ${this.group.scenario}`, onchange: () => { this.rate = Number(rates.value); } },
      RATES.map((rate) => h("option", { value: rate, selected: rate === this.rate }, `${rate}×`)));
    this.view = h("button", { type: "button", onclick: () => this.toggleView() }, "Whole route");
    return h("div", { class: "transport", role: "group", "aria-label": `Playback, ${this.group.scenario}` },
      this.button, this.slider, this.clock, rates, this.view);
  }

  // Space plays and pauses, the arrows step. Returns true if the key was handled.
  key(event) {
    if (event.altKey || event.ctrlKey || event.metaKey || !this.drives) return false;
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (event.key !== " " && !step) return false;
    if (event.key === " ") this.toggle();
    else this.seek(this.time + step * (event.shiftKey ? LONG_STEP_S : STEP_S));
    return true;
  }

  arm(run, index) {
    return h("figure", { class: "arm" },
      h("figcaption", null, h("b", null, run.arm),
        h("span", { class: `tag ${statusTone(run.result.status)}` }, statusWords(run.ended)),
        h("span", { class: "key" }, summary(run))),
      this.stages[index].element, this.plots[index].element);
  }

  // Text of the slider for screen readers.
  spoken() {
    const cars = this.group.runs.map((run) => {
      const stuck = during(run.stuck, this.time) ? ", immobilized" : "";
      return `${run.arm} ${rounded(run.speed[Math.floor(frameAt(run, this.time))] || 0, 1)} m/s${stuck}`;
    });
    return `${rounded(this.time, 2)} of ${seconds(this.range.end)}: ${cars.join("; ")}`;
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

  // `scroll` brings the decision of that time into view in its list. After a click there it is already visible.
  seek(time, scroll = true) {
    this.scroll = scroll;
    this.time = Math.min(this.range.end, Math.max(this.range.start, time));
    this.refresh();
  }

  // Draws once before the next screen refresh, for any number of requests.
  refresh() {
    if (this.pending || (this.drawn && !this.visible)) return;
    this.pending = this.drawn = true;
    requestAnimationFrame(() => {
      this.pending = false;
      this.draw();
    });
  }

  draw() {
    if (this.drives) {
      this.slider.value = this.time;
      this.slider.setAttribute("aria-valuetext", this.spoken());
      this.clock.textContent = `${this.time.toFixed(1)} / ${seconds(this.range.end)}`;
      for (const part of [...this.stages, ...this.plots]) part.draw(this.time);
    }
    for (const record of this.records) record.draw(this.time, this.playing || this.scroll);
  }
}

// Returns the section of a key: the one with the focus, or, without a focus, the first visible one.
function pressed(sections, event) {
  const target = event.target instanceof Element ? event.target : document.body;
  if (target.closest("select, a, summary, textarea, [tabindex]")) return;
  if (event.key === " " && target.closest("button")) return;
  const there = target === document.body
    ? sections.find(({ element }) => element.getBoundingClientRect().bottom > innerHeight / 3)
    : sections.find(({ element }) => element.contains(target));
  if (there && there.key(event)) event.preventDefault();
}

function summary({ result, stopped, recovered }) {
  const parts = [`route ${figure(result.route_completion_pct, 0)} %`];
  if (stopped !== "–") parts.push(`stopped ${withUnit(stopped)}`);
  if (recovered === "never") parts.push("never recovered");
  else if (recovered !== "–") parts.push(`recovered in ${withUnit(recovered)}`);
  return parts.join(" · ");
}

function legend() {
  const entries = [
    ["ego", "ego"], ["scenario", "part of the scenario"], ["traffic", "other traffic"],
    ["vulnerable", "people, two-wheelers"], ["object", "objects"], ["route line", "route"],
    ["trail line", "driven (orange: slow)"], ["recovery line", "recovery path"], ["stuck", "immobilized"],
    ["moment good", "plan accepted"], ["moment bad", "plan refused"], ["moment idle", "wait, or nothing to do"],
    ["guidance dot", "passenger speaks"],
  ];
  return h("ul", { class: "legend" },
    entries.map(([kind, name]) => h("li", null, h("span", { class: `key-mark ${kind}` }), name)));
}
