// Builds the page. Text from the data only becomes text nodes and attribute values, never markup.

const SVG = "http://www.w3.org/2000/svg";

function fill(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes || {})) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else element.setAttribute(name, value === true ? "" : String(value));
  }
  for (const child of children.flat(Infinity)) {
    if (child === null || child === undefined || child === false) continue;
    element.append(child instanceof Node ? child : String(child));
  }
  return element;
}

const h = (tag, attributes, ...children) => fill(document.createElement(tag), attributes, children);
const s = (tag, attributes, ...children) => fill(document.createElementNS(SVG, tag), attributes, children);

// --- words and numbers ---

const UNITS = { m: "m", mps: "m/s", mps2: "m/s²", s: "s", deg: "°", rad: "rad", pct: "%", kmh: "km/h" };

const words = (text) => String(text).replaceAll("_", " ");

const capital = (text) => (text ? text[0].toUpperCase() + text.slice(1) : text);

// Rounds a number, and never returns "-0.0": a number that is rounded to zero has no sign.
const rounded = (value, digits) => value.toFixed(digits).replace(/^-(0(\.0*)?)$/, "$1");

const seconds = (value) => `${rounded(value, 1)} s`;

function figure(value, digits = 1) {
  return value === null || value === undefined ? "–" : rounded(Number(value), digits);
}

// Adds the unit to a number of seconds, which text may follow: `8.0 (1 of 2)` becomes "8.0 s (1 of 2)".
function withUnit(text) {
  return text.replace(/^[\d.]+/, "$& s");
}

// `length_m: 31` becomes "length 31 m".
function labelled(key, value) {
  const unit = key.match(/^(.+)_([a-z0-9]+)$/);
  if (unit && Object.hasOwn(UNITS, unit[2]) && typeof value === "number") {
    return [words(unit[1]), `${Number(rounded(value, 2))} ${UNITS[unit[2]]}`];
  }
  return [words(key), plain(value)];
}

function plain(value) {
  if (value === null || value === undefined) return "–";
  if (typeof value === "boolean") return value ? "yes" : "no";
  if (typeof value === "number") return String(Number(rounded(value, 3)));
  if (Array.isArray(value)) return value.map(plain).join(", ") || "none";
  if (typeof value === "object") {
    return Object.entries(value).map(([key, inner]) => labelled(key, inner).join(" ")).join("; ");
  }
  return String(value);
}

// Returns an empty list or record for a field that a decision of another version lacks or has in another form.
const listOf = (value) => (Array.isArray(value) ? value : []);
const recordOf = (value) => (value && typeof value === "object" && !Array.isArray(value) ? value : {});

// Returns all fields that `known` does not name, as "key: value", so that a newer decision is shown completely.
function otherFacts(record, known) {
  const rest = Object.entries(recordOf(record)).filter(([key, value]) => !known.includes(key) && value !== null);
  if (!rest.length) return null;
  return h("p", { class: "facts" }, rest.map(([key, value], index) => {
    const [name, text] = labelled(key, value);
    return [index ? " · " : "", h("span", { class: "key" }, `${name}: `), text];
  }));
}
