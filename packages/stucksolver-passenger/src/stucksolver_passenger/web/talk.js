// The text of the page: status, question, quick replies and conversation. It is inserted as text, never as HTML.

import { insist, post } from "/files/api.js";

const $ = (id) => document.getElementById(id);
const NAMES = { car: "Car", passenger: "You", operator: "Operator" };
const OPERATOR_NAMES = { car: "Car", passenger: "Passenger", operator: "You" };

function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

export class Talk {
  // `said` is called with each new line of the car.
  constructor(said) {
    this.said = said;
    this.vehicle = "";
    this.role = "passenger";
    this.lines = new Map();
    this.last = 0;
    $("yes").addEventListener("click", () => this.answer(true));
    $("no").addEventListener("click", () => this.answer(false));
    $("stop").addEventListener("click", () => this.send("stop"));
    $("help").addEventListener("click", () => this.send("help"));
    $("say").addEventListener("submit", (event) => {
      event.preventDefault();
      this.say($("words").value);
    });
    $("tell").addEventListener("click", () => this.words("tell", $("words").value));
  }

  begin(vehicle, role) {
    this.vehicle = vehicle;
    this.role = role;
    this.forget();
    $("tell").hidden = role !== "operator";
    $("help").hidden = role === "operator";
  }

  // Starts a new drive.
  forget() {
    this.lines.clear();
    this.last = 0;
    $("lines").replaceChildren();
  }

  // Displays the state of the car (`VehicleReport` of the API).
  show(now) {
    setText($("thought"), now.thought);
    setText($("intention"), now.intention);
    setText($("speed"), `${Math.round(now.speed_mps * 3.6)} km/h`);
    this.ask(now.question);
    this.offer(now.answers, now.ended);
    for (const line of now.lines) this.line(line);
    for (const id of ["stop", "help", "words"]) $(id).disabled = now.ended;
    if (now.ended) document.body.dataset.ended = "yes";
    else delete document.body.dataset.ended;
  }

  ask(question) {
    const mine = question && (question.to === this.role || this.role === "operator") && question.kind !== "advice";
    this.question = mine ? question.id : null;
    $("yes").disabled = $("no").disabled = !mine;
    $("question").classList.toggle("open", Boolean(question));
    setText($("question"), question ? this.asked(question) : "I am not asking anything now.");
  }

  asked(question) {
    return question.to === this.role || question.to === "passenger" ? question.text : `To the operator: ${question.text}`;
  }

  // Yes and no have their own buttons.
  offer(answers, ended) {
    const says = ended ? [] : answers.filter((answer) => answer.does === "say");
    const key = JSON.stringify(says);
    if (key === this.offered) return;
    this.offered = key;
    const had = $("ready").contains(document.activeElement);
    $("ready").replaceChildren(...says.map((answer) => {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = answer.label;
      button.addEventListener("click", () => this.say(answer.says));
      return button;
    }));
    $("ready-title").hidden = !says.length;
    if (had) ($("ready").firstElementChild || $("words")).focus();
  }

  line(line) {
    let shown = this.lines.get(line.number);
    if (!shown) {
      shown = document.createElement("p");
      shown.className = line.speaker;
      const who = document.createElement("span");
      who.className = "who";
      who.textContent = (this.role === "operator" ? OPERATOR_NAMES : NAMES)[line.speaker];
      const text = document.createElement("span");
      text.textContent = line.text;
      shown.append(who, text);
      this.lines.set(line.number, shown);
      const list = $("lines");
      const atEnd = list.scrollHeight - list.scrollTop - list.clientHeight < 60;
      list.append(shown);
      if (atEnd) list.scrollTop = list.scrollHeight;
      if (line.speaker === "car" && line.number > this.last) this.said(line.text);
      this.last = Math.max(this.last, line.number);
    }
    if (line.understood && !shown.querySelector(".understood")) {
      const read = document.createElement("span");
      read.className = "understood";
      read.textContent = `understood: ${line.understood}`;
      shown.append(read);
    }
  }

  say(text) {
    return this.words("say", text);
  }

  async words(how, text) {
    if (!text.trim()) {
      this.outcome("Type something first.", true);
      $("words").focus();
      return;
    }
    if (await this.send(how, { text })) $("words").value = "";
  }

  answer(yes) {
    if (this.question) this.send("answer", { yes, question_id: this.question });
  }

  async send(how, body = {}) {
    try {
      const path = `/api/vehicles/${encodeURIComponent(this.vehicle)}/${how}`;
      const { taken, told } = await (how === "stop" ? insist(path) : post(path, body));
      this.outcome(told, !taken);
      return taken;
    } catch (error) {
      this.outcome(error.message, true);
      return false;
    }
  }

  outcome(text, bad) {
    $("outcome").classList.toggle("bad", bad);
    $("outcome").textContent = text;
  }
}
