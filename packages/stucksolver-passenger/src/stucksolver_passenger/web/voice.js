// Voice input and output. Both are off until a person switches them on. The page states where the sound is sent.

import { BrowsersListener, OwnListener } from "/files/listener.js";

const $ = (id) => document.getElementById(id);
const OWN = "Off until you switch it on. What you say is turned into text in this browser, by files that came from this "
  + "car: the sound stays on this device, only the text goes to the car.";
const BROWSERS = "Off until you switch it on: some browsers send what you say to their vendor for recognition. What "
  + "you type goes to this car only.";

function toggle(button) {
  const on = button.getAttribute("aria-pressed") !== "true";
  button.setAttribute("aria-pressed", String(on));
  return on;
}

// The recognizer of this car, else the browser's own, else none.
async function listener() {
  if (!window.isSecureContext) return null;
  const { version } = await (await fetch("/voice")).json();
  if (version && navigator.mediaDevices && window.AudioWorkletNode) return new OwnListener(version);
  return BrowsersListener.made ? new BrowsersListener() : null;
}

export class Voice {
  // `heard` is called with the recognized text, `told` with an error.
  constructor(heard, told) {
    this.heard = heard;
    this.told = told;
    this.aloud = this.listening = false;
    this.listener = null;
    const speaks = "speechSynthesis" in window;
    $("aloud").hidden = !speaks;
    $("listen").hidden = $("listen-note").hidden = true;
    $("voice").hidden = !speaks;
    $("aloud").addEventListener("click", () => {
      this.aloud = toggle($("aloud"));
      if (!this.aloud) speechSynthesis.cancel();
    });
    $("listen").addEventListener("click", () => {
      $("speak").hidden = !toggle($("listen"));
      if ($("speak").hidden && this.listening) this.listener.abort();
      else if (!$("speak").hidden && this.listener.recognizer) this.listener.recognizer(); // its load takes a while
    });
    $("speak").addEventListener("click", () => this.listenOnce());
    listener().then((found) => this.offer(found), () => {});
  }

  offer(found) {
    this.listener = found;
    if (!found) return;
    $("listen-note").textContent = found instanceof OwnListener ? OWN : BROWSERS;
    $("listen").hidden = $("listen-note").hidden = $("voice").hidden = false;
  }

  say(text) {
    if (!this.aloud) return;
    const spoken = new SpeechSynthesisUtterance(text);
    spoken.lang = "en";
    speechSynthesis.speak(spoken);
  }

  listenOnce() {
    if (this.listening) {
      this.listener.stop();
      return;
    }
    if (this.aloud) speechSynthesis.cancel(); // otherwise the microphone records the output
    this.listening = true;
    $("speak").setAttribute("aria-pressed", "true");
    $("speak").textContent = "One moment …";
    const started = this.listener.start(({ text, failed }) => {
      this.listening = false;
      $("speak").setAttribute("aria-pressed", "false");
      $("speak").textContent = "Speak";
      if (text) this.heard(text);
      else this.told(failed || "I heard nothing.");
    });
    Promise.resolve(started).then(() => {
      if (this.listening) $("speak").textContent = "Listening …";
    });
  }
}
