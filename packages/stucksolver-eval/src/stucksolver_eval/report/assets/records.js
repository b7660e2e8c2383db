// The decisions and events of one system, linked to the slider.

class Records {
  constructor(run, seek) {
    this.run = run;
    this.items = [];
    const count = run.decisions.length;
    this.list = h("div", { class: "cards" },
      count ? grouped(run.decisions).map((group) => this.entry(group, seek))
        : h("p", { class: "empty" }, "No decision was needed."));
    this.rows = run.events.map((event) => ({ time: event.time_s, element: eventRow(event, seek) }));
    this.element = h("section", { class: "records" },
      h("h3", null, run.arm),
      h("h4", null, `Decisions (${count})`), this.list,
      h("details", { class: "events", open: run.events.length <= 40 },
        h("summary", null, `Events (${run.events.length})`),
        run.events.length ? h("ol", null, this.rows.map((row) => row.element)) : h("p", { class: "empty" }, "None.")));
  }

  entry(group, seek) {
    const cards = group.map((moment) => decisionCard(moment, seek));
    cards.forEach((card, index) => this.items.push({ time: group[index].time_s, element: card }));
    if (cards.length === 1) return cards[0];
    const [first, last] = [group[0], group[group.length - 1]];
    const tone = outcomeTone(first.outcome);
    const fold = h("details", { class: `group ${tone}` },
      h("summary", null, h("span", { class: "time" }, `${first.time_s.toFixed(1)}–${seconds(last.time_s)}`),
        h("span", { class: `tag ${tone}` }, `${group.length} × ${outcomeName(first)}`),
        h("span", { class: "ground" }, reasons(group).join("; then "))),
      cards);
    this.items.slice(-cards.length).forEach((item) => { item.fold = fold; });
    return fold;
  }

  // Marks the entry of a time; if `scroll`, brings it into view without moving the page.
  draw(time, scroll) {
    const current = this.items.findLast((item) => item.time <= time);
    if (current !== this.current) {
      this.mark(this.current, false);
      this.mark(current, true);
      this.current = current;
      if (current && scroll) {
        const shown = current.fold && !current.fold.open ? current.fold : current.element;
        this.list.scrollTo({ top: shown.offsetTop - this.list.offsetTop - 8, behavior: "smooth" });
      }
    }
    for (const row of this.rows) row.element.classList.toggle("past", row.time <= time);
  }

  mark(item, on) {
    if (!item) return;
    item.element.classList.toggle("current", on);
    if (item.fold) item.fold.classList.toggle("current", on);
  }
}

// Groups consecutive decisions with the same result: nothing to do, or one plan rejected for one reason repeatedly.
function grouped(decisions) {
  const groups = [];
  let last = null;
  for (const moment of decisions) {
    const key = outcomeTone(moment.outcome) === "good"
      ? null : `${moment.trigger}|${outcomeName(moment)}|${kindOf(moment.decision)}`;
    if (key !== null && key === last) groups[groups.length - 1].push(moment);
    else groups.push([moment]);
    last = key;
  }
  return groups;
}

// Decisions of one kind have the same behaviors, or wait for a reason of the same kind.
function kindOf(decision) {
  return waits(decision) ? recordOf(decision.analysis).wait : headline(decision);
}

// Returns each reason once, in its first form: while a car comes nearer, only the numbers after the comma change.
function reasons(group) {
  const found = new Map();
  for (const { decision } of group) {
    const reason = headline(decision);
    const who = reason.split(",")[0];
    if (!found.has(who)) found.set(who, found.size ? reason.replace(/^[^:]*: /, "") : reason);
  }
  return [...found.values()];
}

// Returns the outcome with the first reason, without the numbers that follow.
function outcomeName(moment) {
  if (waits(moment.decision)) return "wait";
  return moment.codes.length ? `${moment.outcome}: ${words(moment.codes[0])}` : moment.outcome;
}

function eventRow(event, seek) {
  return h("li", { class: `event ${event.kind}` },
    h("button", { type: "button", class: "seek", onclick: () => seek(event.time_s) },
      h("span", { class: "time" }, seconds(event.time_s)),
      h("span", { class: `tag ${event.kind}` }, event.kind),
      h("span", { class: "text" }, event.text)));
}
