// The operator's page: the selected vehicle, and the queue of entries that wait for an answer.

import { get, post } from "/files/api.js";

const $ = (id) => document.getElementById(id);
const EVERY_MS = 1500;

// `about`: the subject of the button, for screen readers, which do not convey its position.
function button(label, about, press) {
  const made = document.createElement("button");
  made.type = "button";
  made.textContent = label;
  made.setAttribute("aria-label", `${label}: ${about}`);
  made.addEventListener("click", press);
  return made;
}

export class Desk {
  // `look` is called with the vehicle to display.
  constructor(look) {
    this.look = look;
    this.shown = "";
    $("desk").hidden = false;
    $("title").textContent = "Operator’s page";
    document.title = "Operator’s page";
    $("vehicle").addEventListener("change", () => this.look($("vehicle").value));
    this.refresh();
    setInterval(() => this.refresh(), EVERY_MS);
  }

  async refresh() {
    try {
      const [vehicles, queue] = await Promise.all([get("/api/vehicles"), get("/api/queue")]);
      this.choose(vehicles);
      this.list(queue);
    } catch {
      // The page reports a lost server elsewhere, and the next poll follows soon.
    }
  }

  choose(vehicles) {
    const key = JSON.stringify(vehicles);
    if (key === this.vehicles) return;
    this.vehicles = key;
    const chosen = $("vehicle").value;
    $("vehicle").replaceChildren(...Object.entries(vehicles).map(([id, name]) => {
      const option = document.createElement("option");
      option.value = id;
      option.textContent = name;
      option.selected = id === chosen;
      return option;
    }));
    if (!chosen && $("vehicle").value) this.look($("vehicle").value);
  }

  list(queue) {
    const key = JSON.stringify(queue.map((call) => [call.id, call.text]));
    if (key === this.shown) return;
    this.shown = key;
    if (!queue.length) {
      const nothing = document.createElement("li");
      nothing.textContent = "Nobody is waiting.";
      $("queue").replaceChildren(nothing);
      return;
    }
    $("queue").replaceChildren(...queue.map((call) => this.call(call)));
  }

  call(call) {
    const item = document.createElement("li");
    const name = document.createElement("strong");
    name.textContent = call.name;
    const text = document.createElement("p");
    text.textContent = call.text;
    const row = document.createElement("div");
    row.className = "row";
    row.append(button("Look", call.name, () => {
      $("vehicle").value = call.vehicle;
      this.look(call.vehicle);
    }));
    if (call.kind === "question") {
      row.append(...[true, false].map((yes) => button(yes ? "Yes" : "No", call.name, () => this.answer(call, yes))));
    } else if (call.kind === "help") {
      row.append(button("Done", call.name, () => this.done(`/api/queue/${encodeURIComponent(call.id)}/close`)));
    }
    item.append(name, text, row);
    return item;
  }

  answer(call, yes) {
    const { vehicle, question_id } = call;
    return this.done(`/api/vehicles/${encodeURIComponent(vehicle)}/answer`, { yes, question_id });
  }

  // The updated queue shows the result. The reason of a failure is displayed with the other outcomes.
  async done(path, body) {
    try {
      await post(path, body);
    } catch (error) {
      $("outcome").textContent = error.message;
    }
    this.refresh();
  }
}
