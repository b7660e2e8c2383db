// Colors are in the style sheet, so that the canvas follows the reader's light or dark scheme.

const VULNERABLE = ["pedestrian", "bicycle", "motorcycle", "animal"];
const OBJECTS = ["cone", "barrier", "debris", "prop"];
const LANE_ORDER = ["other", "median", "sidewalk", "parking", "biking", "shoulder", "driving"];

let palette = null;

function colours() {
  if (palette) return palette;
  const style = getComputedStyle(document.documentElement);
  const read = (name) => style.getPropertyValue(`--${name}`).trim();
  palette = new Proxy({}, {
    get(known, name) {
      if (!(name in known)) known[name] = read(name);
      return known[name];
    },
  });
  return palette;
}

function onSchemeChange(redraw) {
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    palette = null;
    redraw();
  });
}

function laneColour(kind) {
  return colours()[LANE_ORDER.includes(kind) ? `lane-${kind}` : "lane-other"];
}

function actorColour(actor) {
  if (actor.role === "ego") return colours().ego;
  if (VULNERABLE.includes(actor.kind)) return colours().vulnerable;
  if (actor.role === "prop" || OBJECTS.includes(actor.kind)) return colours().object;
  return actor.role === "scenario" ? colours().scenario : colours().traffic;
}

function outcomeTone(outcome) {
  if (outcome === "accepted") return "good";
  return outcome === "refused" ? "bad" : "idle";
}

function statusTone(status) {
  if (["Completed", "Perfect"].includes(status)) return "good";
  return status.startsWith("Failed") ? "bad" : "warn";
}

// "Failed - Agent got blocked": the color shows the first word.
function statusWords(status) {
  return words(status.replace("Failed - ", ""));
}
