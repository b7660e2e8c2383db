// Client of the server. The token leaves this tab only as a header to the server that the page came from.

const KEPT = "stucksolver-token";
const TOKEN = /^#([po]\..+)$/;
const RETRY_MS = [500, 1000, 2000, 4000];
const AGAIN_MS = [50, 250, 500];

// The token follows the # of the address. Browsers never send that part; the page then removes it from the address.
export function token() {
  const told = TOKEN.exec(location.hash);
  if (told) {
    sessionStorage.setItem(KEPT, told[1]);
    history.replaceState(null, "", location.pathname);
  }
  return sessionStorage.getItem(KEPT) || "";
}

// True if the address contains another token.
export const tokenTold = () => TOKEN.test(location.hash);

export function keepToken(text) {
  sessionStorage.setItem(KEPT, text.trim().replace(/^.*#/, ""));
}

const client = Array.from(crypto.getRandomValues(new Uint8Array(12)), (byte) => byte.toString(16).padStart(2, "0")).join("");

function headers() {
  return { authorization: `Bearer ${token()}` };
}

async function read(answer) {
  if (answer.ok) return answer.json();
  let why = `The server answered ${answer.status}.`;
  try {
    const { detail } = await answer.json();
    if (typeof detail === "string") why = detail;
  } catch {
    // Not every error response is JSON. Then its status is the only information.
  }
  const error = new Error(why);
  error.status = answer.status;
  throw error;
}

export async function get(path) {
  return read(await fetch(path, { headers: headers(), cache: "no-store" }));
}

export async function post(path, body = {}) {
  return read(await fetch(path, {
    method: "POST",
    headers: { ...headers(), "content-type": "application/json" },
    body: JSON.stringify({ ...body, client }),
  }));
}

// Posts, and repeats if the connection broke or the server was busy. A stop may be sent twice.
export async function insist(path) {
  for (const pause of [...AGAIN_MS, null]) {
    try {
      return await post(path);
    } catch (error) {
      const lasts = error.status && error.status !== 429 && error.status < 500;
      if (lasts || pause === null) throw error;
      await new Promise((wake) => setTimeout(wake, pause));
    }
  }
}

// Calls hear[event](data) for each of the server's events, and reconnects when the connection breaks.
// `state` is called with "open" and "lost". stop() ends the stream.
export function listen(path, hear, state) {
  const over = new AbortController();
  (async () => {
    for (let failed = 0; !over.signal.aborted; failed += 1) {
      try {
        const answer = await fetch(path, { headers: headers(), signal: over.signal, cache: "no-store" });
        if (!answer.ok) throw new Error(`status ${answer.status}`);
        state("open");
        failed = -1;
        await events(answer.body.getReader(), hear);
      } catch (error) {
        if (over.signal.aborted) return;
      }
      state("lost");
      await new Promise((wake) => setTimeout(wake, RETRY_MS[Math.min(Math.max(failed, 0), RETRY_MS.length - 1)]));
    }
  })();
  return { stop: () => over.abort() };
}

// A blank line separates server-sent events. Each event of this server has one line of data.
async function events(reader, hear) {
  const text = new TextDecoder();
  let rest = "";
  for (;;) {
    const { done, value } = await reader.read();
    if (done) return;
    rest += text.decode(value, { stream: true });
    const whole = rest.split("\n\n");
    rest = whole.pop();
    for (const one of whole) {
      const event = /^event: (.+)$/m.exec(one);
      const data = /^data: (.*)$/m.exec(one);
      if (event && data && Object.hasOwn(hear, event[1])) hear[event[1]](data[1]);
    }
  }
}
