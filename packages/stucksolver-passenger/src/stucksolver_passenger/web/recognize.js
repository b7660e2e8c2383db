// A worker: converts sound to text with Moonshine's English model. All its files come from the page's own server.
//
// The model is an encoder and a decoder (Jeffries et al., "Moonshine: Speech Recognition for Live Transcription and
// Voice Commands", 2024). The decoder outputs one word piece at a time, the most probable one, and caches its state.

const RATE_HZ = 16000;
const PIECES_A_SECOND = 6; // the model's own bound: faster output repeats one phrase endlessly
const LAYERS = 6, HEADS = 8, WIDTH = 36; // of the model "tiny"
const FIRST = 1, LAST = 2; // word pieces at the start and end of a text

const base = new URL(self.location.href).searchParams.get("from");
const ready = load();

async function load() {
  const [ort, { default: tokenizer }] = await Promise.all([import(`${base}/ort.mjs`), import(`${base}/tokenizer.js`)]);
  ort.env.wasm.wasmPaths = `${base}/`;
  ort.env.wasm.numThreads = 1; // more threads need response headers that block other content
  ort.env.logLevel = "error";
  const [encoder, decoder] = await Promise.all(["encoder", "decoder"].map(
    (name) => ort.InferenceSession.create(`${base}/${name}.onnx`, { executionProviders: ["wasm"] })));
  return { ort, tokenizer, encoder, decoder };
}

// The empty cache: the decoder's input at its first word piece.
function empty(ort) {
  const kept = {};
  for (let layer = 0; layer < LAYERS; layer++) {
    for (const part of ["decoder.key", "decoder.value", "encoder.key", "encoder.value"]) {
      kept[`past_key_values.${layer}.${part}`] = new ort.Tensor("float32", new Float32Array(), [0, HEADS, 1, WIDTH]);
    }
  }
  return kept;
}

function likeliest(numbers) {
  let best = 0;
  for (let k = 1; k < numbers.length; k++) if (numbers[k] > numbers[best]) best = k;
  return best;
}

// `sound`: samples at 16 kHz, mono, from -1 to 1.
async function recognize(sound) {
  const { ort, tokenizer, encoder, decoder } = await ready;
  const heard = await encoder.run({ input_values: new ort.Tensor("float32", sound, [1, sound.length]) });
  const most = Math.floor(sound.length / RATE_HZ * PIECES_A_SECOND);
  const pieces = [FIRST];
  let kept = empty(ort);
  for (let step = 0; step < most; step++) {
    const out = await decoder.run({
      input_ids: new ort.Tensor("int64", BigInt64Array.of(BigInt(pieces[step])), [1, 1]),
      encoder_hidden_states: heard.last_hidden_state,
      use_cache_branch: new ort.Tensor("bool", [step > 0]),
      ...kept,
    });
    const piece = likeliest(out.logits.data);
    if (piece === LAST) break;
    pieces.push(piece);
    // The cache of the sound stays as in the first step. Only the cache of the text grows.
    kept = Object.fromEntries(Object.entries(kept).map(([name, before]) => {
      const now = out[name.replace("past_key_values", "present")];
      return [name, step === 0 || name.includes("decoder.") ? now : before];
    }));
  }
  return tokenizer.decode(pieces).trim();
}

ready.then(() => postMessage({ ready: true }), (error) => postMessage({ failed: String(error) }));
self.addEventListener("message", async ({ data }) => {
  try {
    postMessage({ text: await recognize(data) });
  } catch (error) {
    postMessage({ failed: String(error) });
  }
});
