// All runs at a glance, grouped by scenario.

const COLUMNS = [
  ["Arm", (run) => h("b", null, run.arm)],
  ["Status", (run) => h("span", { class: `tag ${statusTone(run.result.status)}` }, statusWords(run.ended))],
  ["Route", (run) => `${figure(run.result.route_completion_pct, 0)} %`, "num"],
  ["Infractions", (run) => infractions(run.result.infractions), "wrap"],
  ["Stopped", (run) => withUnit(run.stopped), "num"],
  ["Time to recover", (run) => withUnit(run.recovered), "num"],
  ["Immobilized", (run) => run.result.immobilizations, "num"],
  ["Decisions", (run) => run.decisions.length, "num"],
  ["Plans accepted", (run) => run.result.plans_accepted, "num"],
  ["Duration", (run) => `${figure(run.result.duration_s)} s`, "num"],
  ["Distance", (run) => `${figure(run.result.distance_m, 0)} m`, "num"],
  ["Reasoner", (run) => run.reasoner],
  ["Perception", (run) => run.perception],
  ["Clock", (run) => run.clock],
];

function infractions(counts) {
  const found = Object.entries(counts).filter(([, count]) => count > 0);
  if (!found.length) return "none";
  return h("span", { class: "bad-text" }, found.map(([name, count]) => `${count} ${words(name)}`).join(", "));
}

function runTable(groups) {
  const head = h("tr", null, COLUMNS.map(([name, , kind]) => h("th", { class: kind, scope: "col" }, name)));
  const bodies = groups.map((group) => h("tbody", null,
    h("tr", { class: "scenario" }, h("th", { colspan: COLUMNS.length, scope: "rowgroup" },
      h("a", { href: `#${group.id}` }, capital(group.scenario)), h("span", { class: "key" }, ` seed ${group.seed}`))),
    group.runs.map((run) => h("tr", null, COLUMNS.map(([, cell, kind]) => h("td", { class: kind }, cell(run)))))));
  return h("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "All runs" },
    h("table", { class: "runs" }, h("thead", null, head), bodies));
}
