// Asks the server: one request, a stream of messages, the last of which is the answer.

/** The server does not answer at all. */
export class Gone extends Error {}

/** What the server says is wrong, and at which field. */
export class Problem extends Error {
  constructor(problem, path) {
    super(problem);
    this.path = path || "";
  }
}

async function reached(request) {
  try {
    return await request();
  } catch (error) {
    if (error.name === "AbortError") throw error;
    throw new Gone("the server does not answer");
  }
}

async function checked(answer) {
  if (answer.ok) return answer;
  const said = await answer.json().catch(() => ({}));
  throw new Problem(said.problem || `the server says ${answer.status}`, "");
}

export async function begin() {
  return (await checked(await reached(() => fetch("/api/begin")))).json();
}

/** Sends a log; gives its key. */
export async function sendLog(file, signal) {
  const ending = file.name.slice(file.name.lastIndexOf(".")).toLowerCase();
  const path = `/api/log?ending=${encodeURIComponent(ending)}`;
  const answer = await reached(() => fetch(path, { method: "POST", body: file, signal }));
  return (await (await checked(answer)).json()).log;
}

/**
 * Has the server do a job.
 * @param {string} job its name
 * @param {object} request what it takes
 * @param {{signal?: AbortSignal, progress?: (done: number, what: string) => void}} how
 * @returns {Promise<{about: object, content: ArrayBuffer}>}
 */
export async function ask(job, request, how = {}) {
  const answer = await checked(await reached(() => fetch(`/api/job/${job}`, {
    method: "POST",
    headers: { "Content-Type": "application/json" },
    body: JSON.stringify(request),
    signal: how.signal,
  })));
  const reader = answer.body.getReader();
  let held = new Uint8Array(0);
  for (;;) {
    const { done, value } = await reached(() => reader.read());
    if (done) throw new Gone("the answer ended before its end");
    held = held.length ? joined(held, value) : value;
    for (let whole; (whole = message(held)); held = held.subarray(whole.size)) {
      const { kind, ...about } = whole.about;
      if (kind === "result") return { about, content: whole.content };
      if (kind === "error") throw new Problem(about.problem, about.path);
      if (kind === "stopped") throw new DOMException("stopped", "AbortError");
      how.progress?.(about.done, about.what);
    }
  }
}

function joined(first, second) {
  const both = new Uint8Array(first.length + second.length);
  both.set(first);
  both.set(second, first.length);
  return both;
}

/** The first whole message in some bytes; null if there is none yet. */
function message(bytes) {
  if (bytes.length < 8) return null;
  const view = new DataView(bytes.buffer, bytes.byteOffset);
  const text = view.getUint32(0, true);
  const size = 8 + text + view.getUint32(4, true);
  if (bytes.length < size) return null;
  const about = JSON.parse(new TextDecoder().decode(bytes.subarray(8, 8 + text)));
  return { about, content: bytes.slice(8 + text, size).buffer, size };
}

/** Rows of 32-bit numbers. */
export function rowsOf(content, points) {
  const count = points ? content.byteLength / (4 * points) : 0;
  return Array.from({ length: count }, (_, i) => new Float32Array(content, 4 * points * i, points));
}
