// Follows a server: the whole state first, then merge patches (RFC 7396). A connection that is lost, or silent for too long, is
// opened again, and begins with the whole state of whoever answers then. Not an EventSource: that can send no token.

const FIRST_PAUSE = 500;
const LONGEST_PAUSE = 8000;
// The server says something every five seconds.
const SILENCE = 15000;

export function merge(target, patch) {
  for (const [key, value] of Object.entries(patch)) {
    if (key === "__proto__") continue;
    if (value === null) {
      delete target[key];
    } else if (typeof value === "object" && !Array.isArray(value)) {
      const before = target[key];
      const isObject = typeof before === "object" && !Array.isArray(before);
      target[key] = merge(isObject ? before : {}, value);
    } else {
      target[key] = value;
    }
  }
  return target;
}

// `on.changed(state)` after every event, `on.status(word)` of "connecting", "live", "reconnecting", "over" and "paused",
// `on.refused(text)` where a token is asked for: then nothing more happens until `open`.
export function follow(on) {
  let state = {};
  let query = "";
  let token = "";
  let current = null;
  let timer = 0;
  let pause = FIRST_PAUSE;

  function receive(text) {
    let name = "";
    let data = "";
    for (const line of text.split("\n")) {
      if (line.startsWith("event:")) name = line.slice(6).trim();
      else if (line.startsWith("data:")) data += line.slice(5);
    }
    if (name === "snapshot") state = merge({}, JSON.parse(data));
    else if (name === "patch") merge(state, JSON.parse(data));
    else return name === "end";
    on.status("live");
    on.changed(state);
    return false;
  }

  async function read(own) {
    let silence = setTimeout(() => own.abort(), SILENCE);
    const heard = () => {
      clearTimeout(silence);
      silence = setTimeout(() => own.abort(), SILENCE);
    };
    try {
      const headers = token ? { authorization: `Bearer ${token}` } : {};
      const answer = await fetch(`events${query}`, { headers, signal: own.signal, cache: "no-store" });
      if (answer.status === 401 || answer.status === 403) return { refused: await answer.text() };
      if (!answer.ok) return {};
      const reader = answer.body.pipeThrough(new TextDecoderStream()).getReader();
      let buffer = "";
      for (;;) {
        const { done, value } = await reader.read();
        if (done) return {};
        heard();
        pause = FIRST_PAUSE;
        buffer += value;
        for (let end = buffer.indexOf("\n\n"); end >= 0; end = buffer.indexOf("\n\n")) {
          const event = buffer.slice(0, end);
          buffer = buffer.slice(end + 2);
          if (receive(event)) return { over: true };
        }
      }
    } catch (error) {
      // No connection, or one that was cut: another try. Anything else is a mistake of ours, and must be seen.
      if (error instanceof TypeError || error.name === "AbortError") return {};
      throw error;
    } finally {
      clearTimeout(silence);
    }
  }

  async function run(own) {
    const end = await read(own);
    if (current !== own) return;
    if (end.refused !== undefined) {
      on.status("refused");
      on.refused(end.refused);
    } else if (end.over) {
      on.status("over");
      // The server waits for this, so that pictures are here before it goes.
      await on.over?.();
      own.abort();
    } else {
      on.status("reconnecting");
      timer = setTimeout(begin, pause * (0.75 + 0.5 * Math.random()));
      pause = Math.min(2 * pause, LONGEST_PAUSE);
    }
  }

  function begin() {
    current = new AbortController();
    run(current);
  }

  function close() {
    clearTimeout(timer);
    const own = current;
    current = null;
    own?.abort();
  }

  return {
    // Opens the stream, or opens it anew with another view or token.
    open(view = {}, bearer = "") {
      close();
      const text = new URLSearchParams(view).toString();
      query = text ? `?${text}` : "";
      token = bearer;
      pause = FIRST_PAUSE;
      begin();
    },
    close() {
      close();
      on.status("paused");
    },
  };
}

// Asks the server to do something; returns what it says, throws what it says against it.
export async function act(action, of, token = "") {
  const headers = { "content-type": "application/json", "x-gonio-page": "1" };
  if (token) headers.authorization = `Bearer ${token}`;
  const answer = await fetch(`act/${action}`, { method: "POST", headers, body: JSON.stringify(of) });
  const text = await answer.text();
  if (!answer.ok) throw new Error(text || `refused (${answer.status})`);
  return text;
}
