// Recognizes one sentence: with a recognizer in this browser whose files come from the car, or with the browser's own.
// Both have start(hear), stop() and abort(). At the end hear is called once, with {text}, {failed} or {}.

const RATE_HZ = 16000; // sample rate of the model's input
const QUIET_S = 1.0; // silence after speech that ends a sentence
const NOTHING_S = 6.0; // time without any speech after which recognition ends
const LONGEST_S = 15.0;
const LOUD = 0.01; // root mean square of a block of 3 ms: a quiet room is well below, speech is above. Ours
// Silence that remains around speech. With a second of it the model returns no text for half of all sentences.
const BEFORE_S = 0.25;
const AFTER_S = 0.2;

// The model was trained on unfiltered recordings with noise. The filters of browsers cost words.
const AS_IT_IS = { channelCount: 1, echoCancellation: false, noiseSuppression: false, autoGainControl: false };

// Converts sound to text in this browser. Only the text is sent to the car.
export class OwnListener {
  constructor(version) {
    this.version = version;
    this.worker = null;
  }

  async start(hear) {
    this.hear = hear;
    this.blocks = [];
    this.began = performance.now();
    this.spoke = null;
    try {
      this.recognizer();
      this.stream = await navigator.mediaDevices.getUserMedia({ audio: AS_IT_IS });
      this.context = new AudioContext();
      await this.context.audioWorklet.addModule("/files/capture.js");
      this.node = new AudioWorkletNode(this.context, "capture");
      this.node.port.onmessage = ({ data }) => this.take(data);
      this.context.createMediaStreamSource(this.stream).connect(this.node);
    } catch (error) {
      this.end({ failed: error.name === "NotAllowedError" ? "The browser does not let me use the microphone."
        : `I cannot listen: ${error.message}` });
    }
  }

  recognizer() {
    if (this.worker) return;
    const from = encodeURIComponent(`/voice/${this.version}`);
    this.worker = new Worker(`/files/recognize.js?from=${from}`, { type: "module" });
    this.worker.addEventListener("message", ({ data }) => {
      if (!data.ready) this.end(data);
    });
    this.worker.addEventListener("error", () => this.end({ failed: "The recognizer could not be loaded." }));
  }

  take(block) {
    if (!this.node) return;
    if (!this.spoke && this.blocks.length > BEFORE_S * this.context.sampleRate / block.length) this.blocks.shift();
    this.blocks.push(block);
    const now = performance.now();
    const power = block.reduce((sum, sample) => sum + sample * sample, 0) / block.length;
    if (Math.sqrt(power) > LOUD) {
      this.spoke = now;
      this.upTo = this.blocks.length;
    }
    const over = this.spoke ? now - this.spoke > 1000 * QUIET_S : now - this.began > 1000 * NOTHING_S;
    if (over || now - this.began > 1000 * LONGEST_S) this.stop();
  }

  // Ends the recording and recognizes it.
  async stop() {
    if (!this.node) return;
    const rate = this.context.sampleRate;
    const after = this.blocks.length ? Math.ceil(AFTER_S * rate / this.blocks[0].length) : 0;
    this.mute();
    if (!this.spoke) {
      this.end({});
      return;
    }
    this.worker.postMessage(await resampled(this.blocks.slice(0, this.upTo + after), rate));
  }

  abort() {
    this.mute();
    this.end({});
  }

  mute() {
    this.node = null;
    for (const track of this.stream ? this.stream.getTracks() : []) track.stop();
    if (this.context) this.context.close();
    this.stream = this.context = null;
  }

  end(what) {
    if (this.stream) this.mute();
    const hear = this.hear;
    this.hear = null;
    if (hear) hear(what);
  }
}

async function resampled(blocks, rate) {
  const length = blocks.reduce((sum, block) => sum + block.length, 0);
  const count = Math.max(Math.ceil(length * RATE_HZ / rate), 1);
  const offline = new OfflineAudioContext(1, count, RATE_HZ);
  const buffer = offline.createBuffer(1, length, rate);
  let at = 0;
  for (const block of blocks) {
    buffer.copyToChannel(block, 0, at);
    at += block.length;
  }
  const source = offline.createBufferSource();
  source.buffer = buffer;
  source.connect(offline.destination);
  source.start();
  return (await offline.startRendering()).getChannelData(0);
}

// The browser's own recognizer. Some browsers send the sound to their vendor.
export class BrowsersListener {
  static get made() {
    return window.SpeechRecognition || window.webkitSpeechRecognition;
  }

  start(hear) {
    let found = {};
    this.recognition = new BrowsersListener.made();
    this.recognition.lang = "en";
    this.recognition.addEventListener("result", (event) => { found = { text: event.results[0][0].transcript }; });
    this.recognition.addEventListener("error", (event) => { found = { failed: `The browser says: ${event.error}` }; });
    this.recognition.addEventListener("end", () => hear(found));
    this.recognition.start();
  }

  stop() {
    this.recognition.stop();
  }

  abort() {
    this.recognition.abort();
  }
}
