// Reads the embedded data and builds the page.

function groupRuns(runs) {
  const groups = new Map();
  for (const run of runs) {
    const key = JSON.stringify([run.scenario, run.seed]);
    if (!groups.has(key)) {
      groups.set(key, { id: `scenario-${groups.size + 1}`, scenario: run.scenario, seed: run.seed, runs: [] });
    }
    groups.get(key).runs.push(run);
  }
  return [...groups.values()];
}

function main() {
  const data = JSON.parse(document.getElementById("data").textContent);
  const maps = data.maps.map(decodeMap);
  const groups = groupRuns(data.runs.map((run) => decodeRun(run, maps[run.map])));
  const sections = groups.map((group) => new Section(group));
  document.getElementById("report").replaceChildren(
    h("header", { class: "page" }, h("h1", null, data.title),
      data.notes.length ? h("ul", { class: "notes" }, data.notes.map((note) => h("li", null, note))) : ""),
    groups.length ? runTable(groups) : h("p", { class: "empty" }, "No runs."),
    ...sections.map((section) => section.element));
  document.addEventListener("keydown", (event) => pressed(sections, event));
  onSchemeChange(() => sections.forEach((section) => section.refresh()));
}

main();
