// A decision as a card with the chain's three steps. Fields that are unknown to this page are shown as key: value.

const PARTICIPANT = ["Participant", "Lane", "Distance", "Intent"];

function decisionCard(moment, seek) {
  const { decision } = moment;
  const analysis = recordOf(decision.analysis);
  const tone = outcomeTone(moment.outcome);
  const body = h("details", { open: tone === "good" },
    h("summary", null, "Observation, analysis, decision"),
    step("1", "Observation", observation(recordOf(decision.observation))),
    step("2", "Analysis", analysed(analysis)),
    step("3", "Decision", planned(decision)),
    otherFacts(decision, ["version", "observation", "analysis", "plan", "rationale"]));
  const [named, why] = [headline(decision), capital(plain(decision.rationale || ""))];
  return h("article", { class: `card ${tone}` },
    h("button", { class: "seek", type: "button", onclick: () => seek(moment.time_s), title: "Show this moment" },
      h("span", { class: "time" }, seconds(moment.time_s)),
      h("span", { class: "tag" }, moment.trigger),
      h("span", { class: `tag ${tone}` }, waits(decision) ? "wait" : words(moment.verdict))),
    h("p", { class: "headline" }, named),
    why && why !== named && h("p", { class: "rationale" }, why),
    picture(moment),
    body);
}

// The front camera's picture at the time of the query, if it was recorded.
function picture(moment) {
  if (typeof moment.picture !== "string" || !/^[A-Za-z0-9+/]+=*$/.test(moment.picture)) return null;
  const alt = `The front camera's picture, ${seconds(moment.time_s)}`;
  return h("img", { class: "seen", src: `data:image/jpeg;base64,${moment.picture}`, alt, loading: "lazy" });
}

function step(number, name, content) {
  return h("section", { class: "step" }, h("h5", null, h("span", { class: "number" }, number), name), content);
}

const waits = (decision) => !decision.plan && Boolean(recordOf(decision.analysis).wait);

// The decision in a line: the behaviors, or the reason for none.
function headline(decision) {
  const names = listOf(recordOf(decision.plan).behaviors)
    .map((one) => words(one.name) + (typeof one.side === "string" ? ` ${words(one.side)}` : ""));
  return capital(names.join(", then ") || plain(decision.rationale || ground(recordOf(decision.analysis))));
}

// An immobilized vehicle may have to wait before it passes. This does not apply to other vehicles.
function ground(analysis) {
  const state = analysis.immobilized ? "immobilized" : "not immobilized";
  const cause = analysis.cause ? `: ${words(analysis.cause)}` : "";
  const before = analysis.immobilized ? "waits before it passes" : "waits";
  return `${state}${cause}${analysis.wait ? `; ${before}: ${words(analysis.wait)}` : ""}`;
}

function observation(seen) {
  const controls = listOf(seen.controls).map((control) => h("li", null,
    h("b", null, words(control.kind)), control.state ? ` ${words(control.state)}` : "",
    control.applies === false ? ", for others" : control.applies === null ? ", for us?" : "",
    control.distance_m === null || control.distance_m === undefined ? "" : `, ${figure(control.distance_m)} m`,
    otherFacts(control, ["kind", "state", "applies", "distance_m"])));
  const known = ["object_id", "kind", "lane", "distance_m", "intent"];
  const participants = listOf(seen.participants).map((one) => h("tr", null,
    h("td", null, h("b", null, words(plain(one.kind))), ` #${plain(one.object_id)}`, otherFacts(one, known)),
    h("td", null, words(plain(one.lane))),
    h("td", { class: "num" }, `${figure(one.distance_m)} m`),
    h("td", null, words(plain(one.intent)))));
  return [
    seen.summary && h("p", null, capital(plain(seen.summary))),
    h("p", { class: "key" }, "Traffic controls: ", controls.length ? "" : "none"),
    controls.length ? h("ul", null, controls) : null,
    participants.length
      ? h("div", { class: "scroll" }, h("table", { class: "participants" },
        h("thead", null, h("tr", null, PARTICIPANT.map((name) => h("th", null, name)))),
        h("tbody", null, participants)))
      : h("p", { class: "key" }, "Participants: none"),
    otherFacts(seen, ["summary", "controls", "participants"]),
  ];
}

function answered(answer) {
  const text = answer === null || answer === undefined ? "unknown" : plain(answer);
  return h("span", { class: `answer ${text}` }, text);
}

function analysed(analysis) {
  const known = ["steps", "immobilized", "cause", "wait", "guidance_intent", "reason"];
  return [
    h("ol", { class: "chain" }, listOf(analysis.steps).map((one) => h("li", null,
      h("span", { class: "id" }, one.id),
      h("span", { class: "question" }, one.question),
      answered(one.answer),
      one.evidence && h("span", { class: "evidence" }, one.evidence),
      otherFacts(one, ["id", "question", "answer", "evidence"])))),
    h("p", { class: "result" }, h("b", null, capital(ground(analysis))),
      analysis.guidance_intent ? ` · passenger asks: ${words(analysis.guidance_intent)}` : "",
      analysis.reason ? `. ${capital(analysis.reason)}` : ""),
    otherFacts(analysis, known),
  ];
}

function planned({ plan, analysis }) {
  if (!plan && recordOf(analysis).wait) return h("p", null, "No plan yet: the vehicle waits and will be checked again.");
  if (!plan) return h("p", null, "No plan: the vehicle's own stack drives on.");
  return [
    h("ol", { class: "behaviors" }, listOf(plan.behaviors).map((one) => h("li", null,
      h("b", null, words(one.name)), otherFacts(one, ["name"])))),
    h("p", null, plan.replan_route
      ? `Replan the route${plan.route_start ? ` from ${plan.route_start}` : ""}.`
      : "Keep the route."),
    otherFacts(plan, ["behaviors", "replan_route", "route_start"]),
  ];
}
