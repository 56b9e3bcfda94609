// The page of a phone: clock, connection, votes, words. page_stage.js follows in the same script.
const $ = id => document.getElementById(id);
const kept = {};
const keep = {
  get: k => { try { return localStorage.getItem(k) ?? kept[k] ?? "" } catch { return kept[k] || "" } },
  set: (k, v) => { kept[k] = v; try { localStorage.setItem(k, v) } catch { /* some private windows keep nothing */ } },
};
const calm = matchMedia("(prefers-reduced-motion: reduce)");
let tongue = keep.get("tongue") in WORDS ? keep.get("tongue") : document.documentElement.lang;
if (!(tongue in WORDS)) tongue = "en";
let say = WORDS[tongue];
// Names come from others: they are put in as text, and set apart, so that their direction changes nothing around them.
const fill = (text, values) => text.replace(/\{(\w+)\}/g, (_, key) => key === "n" ? values.n : `\u2068${values[key]}\u2069`);

// -- the show's clock: ping, and believe the quickest answers ---------------------------------------------------------
const mine = () => performance.now() / 1000;
let offset = null, series = [], pingTimer = 0;
function ping(left) {
  clearTimeout(pingTimer);
  if (!open()) return;
  const data = new DataView(new ArrayBuffer(9));
  data.setUint8(0, 2); data.setFloat64(1, mine(), true);
  socket.send(data.buffer);
  pingTimer = left > 1 ? setTimeout(ping, 120 + 60 * Math.random(), left - 1)
    : setTimeout(ping, 10000 + 10000 * Math.random(), 8);
}
function pong(data) {
  const now = mine(), sent = data.getFloat64(1, true), there = data.getFloat64(9, true), trip = now - sent;
  series.push({ trip, at: there + trip / 2 - now, when: now });
  series = series.filter(one => now - one.when < 30).slice(-24);
  const best = [...series].sort((a, b) => a.trip - b.trip).slice(0, Math.max(1, series.length >> 2));
  const wanted = best.map(one => one.at).sort((a, b) => a - b)[best.length >> 1];
  offset = offset === null || Math.abs(wanted - offset) > 0.05 ? wanted : offset + 0.5 * (wanted - offset);
}
const showTime = () => offset === null ? null : mine() + offset;
let clock = null;
function beat() {
  const time = showTime();
  return time === null || !clock ? null : clock[1] + (time - clock[0]) * clock[2] / 60;
}

// -- the connection: with back-off and jitter, so that a hall does not come back all at once ---------------------------
let socket = null, tries = 0, againTimer = 0, state = null, me = null, why = "joining", heardAt = 0;
let key = location.hash.slice(1), turnAt = 0;
const SILENT = 0, HEARD = 1, SEEN = 2, WAITS = 3, NONE = 4;
let hearing = SILENT;
const open = () => socket && socket.readyState === 1;
function connect() {
  clearTimeout(againTimer);
  if (socket && socket.readyState < 2) return;
  if (!key && !keep.get("token") && !keep.get("voucher")) { why = "link"; words(); return }
  const fresh = socket = new WebSocket((location.protocol === "https:" ? "wss://" : "ws://") + location.host + "/ws");
  fresh.binaryType = "arraybuffer"; heardAt = mine();
  fresh.onopen = () => {
    const hello = { r: +keep.get("region") || 0 };
    if (keep.get("token")) hello.t = keep.get("token");
    if (key) hello.k = key;
    if (keep.get("voucher")) hello.v = keep.get("voucher");
    fresh.send(JSON.stringify(hello));
  };
  fresh.onmessage = e => {
    if (socket !== fresh) return;
    heardAt = mine();
    if (typeof e.data === "string") { hear(JSON.parse(e.data)); return }
    const data = new DataView(e.data);
    if (data.getUint8(0) === 2) pong(data); else if (data.getUint8(0) === 6) stage(data);
  };
  fresh.onclose = () => {
    if (socket !== fresh) return;
    if (me) { why = "away"; me = null }
    words();
    if (why !== "link") again();
  };
}
function again() {  // when the door says so, else sooner or later
  clearTimeout(againTimer);
  const most = Math.min(20, 0.8 * 2 ** tries++), told = turnAt - mine();
  againTimer = setTimeout(connect, 1000 * (told > 0 ? told : 0.1 + most * Math.random()));
}
function hear(said) {
  if (said.w) {
    const [token, number, hue, every, region] = said.w;
    keep.set("token", token); keep.set("voucher", ""); turnAt = 0;
    me = { number, hue, every, region, colour: `hsl(${hue * 0.36}deg 90% 66%)` };
    tries = 0; why = ""; key = ""; hearing = SILENT;
    if (location.hash) history.replaceState(null, "", location.pathname);
    document.documentElement.style.setProperty("--mine", me.colour);
    series = []; voteAgain = true; ping(8); send(); awake();
  } else if (said.no) {
    why = ["token", "spent"].includes(said.no) ? "link" : said.no;
    turnAt = said.in > 0 ? mine() + said.in : 0;
    if (said.v) keep.set("voucher", said.v);
    if (why === "link") { keep.set("token", ""); keep.set("voucher", ""); key = "" }
  } else if (said.c) {
    clock = said.c; beatDots();
  } else if (said.s) {
    const old = state; state = said.s;
    if (old && old.vote && (!state.vote || state.vote[0] !== old.vote[0])) closeVote(old.vote);
    seats(); ballot();
    if (voteAgain && state.vote && chosen[0] === state.vote[0] && chosen[1] >= 0) order(3, chosen[0] % 256, chosen[1]);
    voteAgain = false;
  } else if (said.n) {
    tally = said.n; bars();
  } else if (said.g) colours = said.g;
  else if ("h" in said) hearing = said.h;
  else if ("e" in said && me) me.every = said.e;
  words();
}
setInterval(() => {
  if (socket && socket.readyState < 2 && heardAt && mine() - heardAt > 12) lost();
}, 2000);
function lost() {  // a close waits for an answer that will not come: begin anew at once
  const old = socket;
  if (me) { why = "away"; me = null }
  socket = null; heardAt = 0; words();
  try { old.close() } catch { /* it is gone */ }
  again();
}
document.addEventListener("visibilitychange", () => {
  if (document.hidden) { lift(); return }
  if (!open()) { tries = 0; clearTimeout(againTimer); againTimer = setTimeout(connect, Math.max(300 * Math.random(), 1000 * (turnAt - mine()))) }
  else { series = []; ping(8) }
  awake();
});
addEventListener("online", () => {
  tries = 0;
  if (open() && mine() - heardAt > 5) lost(); else if (!open()) again();
});
addEventListener("hashchange", () => {  // another link in the same tab
  if (location.hash.length > 1 && !me) { key = location.hash.slice(1); why = "joining"; turnAt = 0; words(); connect() }
});
async function awake() {
  try { await navigator.wakeLock.request("screen") } catch { /* only where the page came by https */ }
}

// -- seats, votes, shaking -----------------------------------------------------------------------------------------------
const RESULT_MS = 10000;
function order(...bytes) { if (open() && me) socket.send(new Uint8Array(bytes)) }
let seatNames = "";
function seats() {
  const box = $("where"), names = state.regions, now = JSON.stringify([names, tongue]);
  box.hidden = names.length < 2;
  if (now !== seatNames) {  // made anew only if others come: whoever is on a button with the keyboard stays there
    seatNames = now;
    const label = document.createElement("span"); label.id = "seat"; label.textContent = say.seat;
    box.replaceChildren(label, ...names.map((name, index) => {
      const one = document.createElement("button");
      one.textContent = name; one.dir = "auto";
      one.onclick = () => { keep.set("region", index); if (me) me.region = index; order(4, index); seats(); words() };
      return one;
    }));
  }
  [...box.querySelectorAll("button")].forEach((one, index) => one.setAttribute("aria-pressed", String(me !== null && me.region === index)));
}
let chosen = [0, -1], voteAgain = false, tally = [], result = null, resultTimer = 0, shown = "";
function closeVote(vote) {  // its bars and the winner stay for a while
  const [number, name] = state.won;
  if (number !== vote[0] || !name) { result = null; return }
  result = { vote, name };
  clearTimeout(resultTimer); resultTimer = setTimeout(() => { result = null; ballot(); words() }, RESULT_MS);
}
function ballot() {
  const vote = state && state.open && (state.vote || result && result.vote), over = vote && !state.vote;
  $("vote").hidden = !vote;
  $("vote").classList.toggle("over", !!over);
  if (!vote) { $("choices").replaceChildren(); shown = ""; return }
  if (chosen[0] !== vote[0]) chosen = [vote[0], -1];
  if (shown !== JSON.stringify(vote.slice(0, 3))) {
    shown = JSON.stringify(vote.slice(0, 3));
    $("choices").replaceChildren(...vote[2].map((name, index) => {
      const one = document.createElement("button");
      for (const tag of ["span", "b", "u"]) one.append(document.createElement(tag));
      one.children[0].textContent = name; one.children[0].dir = "auto"; one.children[2].append(document.createElement("i"));
      one.onclick = () => { if (!state.vote) return; chosen = [vote[0], index]; order(3, vote[0] % 256, index); buzz(); ballot() };
      return one;
    }));
  }
  [...$("choices").children].forEach((one, index) => {
    one.setAttribute("aria-pressed", String(chosen[1] === index));
    one.setAttribute("aria-disabled", String(!!over));
    one.classList.toggle("won", !!over && vote[2][index] === result.name);
  });
  bars();
}
function bars() {
  const vote = state && (state.vote || result && result.vote);
  if (!vote || $("vote").hidden) return;
  const counts = tally[0] === vote[0] ? tally.slice(1) : [], all = counts.reduce((a, b) => a + b, 0);
  [...$("choices").children].forEach((one, index) => {
    const share = all ? (counts[index] || 0) / all : 0, text = all ? `${Math.round(100 * share)} %` : "";
    if (one.children[1].textContent !== text) one.children[1].textContent = text;
    one.children[2].firstChild.style.transform = `scaleX(${share.toFixed(3)})`;
  });
}
let force = 0, shakenAt = 0;
function motion(event) {
  const a = event.accelerationIncludingGravity;
  if (!a || a.x === null) return;
  const now = mine(), size = Math.hypot(a.x, a.y, a.z);
  force = 0.8 * force + 0.2 * Math.abs(size - 9.8);
  if (force > 6 && now - shakenAt > 0.25 && state && state.shake) { shakenAt = now; order(5, Math.min(255, Math.round(force * 8))) }
}
if (window.DeviceMotionEvent && isSecureContext) {
  const ask = DeviceMotionEvent.requestPermission;
  if (ask) { $("shake").hidden = false; $("shake").onclick = async () => {
    try { if (await ask.call(DeviceMotionEvent) === "granted") { addEventListener("devicemotion", motion); $("shake").hidden = true } } catch { /* not here */ }
  } } else addEventListener("devicemotion", motion);
}

// -- words and pictures --------------------------------------------------------------------------------------------------
function put(id, text) { if ($(id).textContent !== text) $(id).textContent = text }
function words() {
  document.documentElement.lang = tongue;
  document.title = say.title;
  put("tag", tongue); $("tongue").setAttribute("aria-label", say.language);
  put("come", say.come); put("go", say.go); put("how", say.how); put("shake", say.shake);
  canvas.setAttribute("aria-label", say.stage);
  put("said", said());
  const light = why || !state || !state.open ? "" : ["", "heard", "seen", "none", "none"][hearing];
  if ($("me").className !== light) $("me").className = light;
}
function said() {
  if (why) return (say[why] || say.away) + left();
  if (!state) return say.joining;
  if (!state.open) return say.closed;
  if (result && !state.vote) return fill(say.won, { who: result.name });
  if (hearing === WAITS) return say.waits;
  if (hearing === NONE) return say.none;
  if (state.muted) return say.muted;
  return hearing === SEEN ? say.seen : hearing === HEARD ? say.heard : say.drag;
}
function left() {  // seconds until its turn to come in
  const wait = 5 * Math.ceil((turnAt - mine()) / 5);  // in steps: a screen reader says each
  return turnAt && wait > 0 && !open() ? ` (${wait} s)` : "";
}
setInterval(() => { if (turnAt && !me) words() }, 1000);
$("tongue").append(...Object.entries(WORDS).map(([code, { name }]) => {
  const one = document.createElement("option");
  one.value = code; one.textContent = name; one.lang = code;
  return one;
}));
$("tongue").value = tongue;
$("tongue").onchange = () => {
  tongue = $("tongue").value; say = WORDS[tongue]; keep.set("tongue", tongue);
  words(); if (state) { seats(); ballot() }
};
function beatDots() {
  const many = Math.min(clock[3], 16);
  if ($("beats").children.length !== many) {
    $("beats").replaceChildren(...Array.from({ length: many }, (_, i) => {
      const dot = document.createElement("i"); if (!i) dot.className = "one"; return dot;
    }));
  }
}
function count(now) {
  const turn = state && state.open && state.turn, vote = state && state.vote;
  let text = "";
  if (turn && me && now !== null && now < turn[2]) {
    const left = Math.max(0, Math.ceil(turn[1] - now)), own = me.region === turn[0];
    if (left <= clock[3]) text = fill((own ? say.mine : say.theirs)[left > 0 ? 1 : 0], { n: left, who: state.regions[turn[0]] });
  }
  put("turn", text);
  if (vote) {
    const beats = now === null ? -1 : Math.max(0, Math.ceil(vote[3] - now));
    put("ask", say.vote[vote[1]] + (beats < 0 ? "" : ` – ${fill(say.closes[beats === 1 ? 0 : 1], { n: beats })}`));
  } else if (result) put("ask", fill(say.won, { who: result.name }));
}
