// Connects the parts of the page.

import { get, keepToken, listen, token, tokenTold } from "/files/api.js";
import { Desk } from "/files/operator.js";
import { Talk } from "/files/talk.js";
import { View, canDraw } from "/files/view.js";
import { Voice } from "/files/voice.js";

const $ = (id) => document.getElementById(id);
const calm = matchMedia("(prefers-reduced-motion: reduce)");
const CALM_MS = 1000;

const voice = new Voice((text) => talk.say(text), (why) => talk.outcome(why, true));
const talk = new Talk((text) => voice.say(text));
const view = canDraw() ? new View($("canvas")) : null;
let stream = null;
let paused = false;
let names = {};
const shown = { view: 0, picture: 0 };

// Pictures can be paused. With the setting for reduced motion they come once a second.
function due(what) {
  if (paused) return false;
  const now = performance.now();
  if (calm.matches && now - shown[what] < CALM_MS) return false;
  shown[what] = now;
  return true;
}

const hear = {
  hello: (data) => {
    $("name").textContent = JSON.parse(data);
    talk.forget();
  },
  now: (data) => talk.show(JSON.parse(data)),
  scenery: (data) => {
    if (!view) return;
    view.scenery(JSON.parse(data));
    $("above").hidden = false;
  },
  view: (data) => {
    if (view && due("view")) view.show(JSON.parse(data));
  },
  picture: (data) => {
    if (!due("picture")) return;
    $("picture").src = `data:image/jpeg;base64,${data}`;
    $("picture").hidden = false;
    $("no-picture").hidden = true;
  },
};

function linked(state) {
  $("link").textContent = state === "open" ? "Connected" : "Connection lost, trying again …";
  $("link").classList.toggle("bad", state !== "open");
}

function look(vehicle, role) {
  if (stream) stream.stop();
  talk.begin(vehicle, role);
  $("name").textContent = names[vehicle] || vehicle;
  $("ride").hidden = false;
  stream = listen(`/api/vehicles/${encodeURIComponent(vehicle)}/stream`, hear, linked);
}

$("pause").addEventListener("click", () => {
  paused = !paused;
  $("pause").setAttribute("aria-pressed", String(paused));
});

$("enter-form").addEventListener("submit", (event) => {
  event.preventDefault();
  keepToken($("code").value);
  begin();
});

async function begin() {
  if (!token()) {
    enter("No code yet");
    return;
  }
  try {
    const me = await get("/api/me");
    $("enter").hidden = true;
    names = me.vehicles;
    if (me.role === "operator") new Desk((vehicle) => look(vehicle, "operator"));
    else look(me.vehicle, me.role);
  } catch (error) {
    if (error.status === 401) enter("That code is not right");
    else {
      linked("lost");
      setTimeout(begin, CALM_MS);
    }
  }
}

function enter(why) {
  $("enter").hidden = false;
  $("name").textContent = "";
  $("link").textContent = why;
  $("code").focus();
}

addEventListener("hashchange", () => {
  if (tokenTold()) location.reload();
});
begin();
