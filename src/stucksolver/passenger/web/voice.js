// Voice in and out, by what the browser has. Both are off until somebody switches them on.

const $ = (id) => document.getElementById(id);
const Recognition = window.SpeechRecognition || window.webkitSpeechRecognition;

function toggle(button) {
  const on = button.getAttribute("aria-pressed") !== "true";
  button.setAttribute("aria-pressed", String(on));
  return on;
}

export class Voice {
  // `heard` is called with what was recognized.
  constructor(heard) {
    this.heard = heard;
    this.aloud = false;
    const speaks = "speechSynthesis" in window;
    const listens = Boolean(Recognition) && window.isSecureContext;
    $("aloud").hidden = !speaks;
    $("listen").hidden = $("listen-note").hidden = !listens;
    $("voice").hidden = !speaks && !listens;
    $("aloud").addEventListener("click", () => {
      this.aloud = toggle($("aloud"));
      if (!this.aloud) speechSynthesis.cancel();
    });
    $("listen").addEventListener("click", () => {
      $("speak").hidden = !toggle($("listen"));
      if ($("speak").hidden && this.recognition) this.recognition.abort();
    });
    $("speak").addEventListener("click", () => this.listenOnce());
  }

  say(text) {
    if (!this.aloud) return;
    const spoken = new SpeechSynthesisUtterance(text);
    spoken.lang = "en";
    speechSynthesis.speak(spoken);
  }

  listenOnce() {
    if (this.recognition) {
      this.recognition.stop();
      return;
    }
    if (this.aloud) speechSynthesis.cancel(); // it would hear itself
    this.recognition = new Recognition();
    this.recognition.lang = "en";
    this.recognition.addEventListener("result", (event) => this.heard(event.results[0][0].transcript));
    this.recognition.addEventListener("end", () => {
      this.recognition = null;
      $("speak").setAttribute("aria-pressed", "false");
      $("speak").textContent = "Speak";
    });
    this.recognition.start();
    $("speak").setAttribute("aria-pressed", "true");
    $("speak").textContent = "Listening …";
  }
}
