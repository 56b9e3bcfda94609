"use strict";
// The camera page: the model sees a dancer in the camera's pictures, here, and her joints go to the show. A packet is that
// of live/control/camera/phone_landmarks.py; nothing else is sent but pings and the performer's name.
const $ = id => document.getElementById(id);
const STORED = "live.camera.key", CHOICES = "live.camera.choices";
const HEAD = 15, POINT = 11, POINTS = 33, FRAME_MS = 1000 / 31, SLOW = 12, SLOW_AFTER = 6000, NOBODY_MS = 200, LATE_MS = 250;
const BONES = [[11, 12], [11, 13], [13, 15], [12, 14], [14, 16], [11, 23], [12, 24], [23, 24], [23, 25], [25, 27], [24, 26],
  [26, 28], [27, 29], [29, 31], [27, 31], [28, 30], [30, 32], [28, 32], [15, 19], [16, 20], [0, 11], [0, 12]];
const kept = {};
const keep = {
  get: name => { try { return localStorage.getItem(name) ?? kept[name] ?? ""; } catch { return kept[name] || ""; } },
  set: (name, text) => { kept[name] = text; try { localStorage.setItem(name, text); } catch { /* while this page is open */ } },
};
const mine = () => performance.now() / 1000;

// -- words ------------------------------------------------------------------------------------------------------------
let trouble = "", asked = "";
function word() {
  const connected = socket && socket.readyState === 1;
  const text = trouble || (!connected ? asked || "the show does not answer; asking again" : !who() ? "choose who is seen" : asked
    || (!stream ? "ready" : seen === null ? "the model is being loaded" : !seen ? "nobody is seen"
      : late > LATE_MS ? "a dancer is seen, but this device is slow: she is shown late" : "a dancer is seen"));
  if ($("word").textContent !== text) $("word").textContent = text;
  $("word").className = trouble || asked || !connected ? "wrong" : "";
}

// -- the key, from the link's end, which browsers send to nobody ------------------------------------------------------------
let key = "";
function take(text) {
  const found = text.includes("key=") ? text.split("key=")[1].split("&")[0] : text;
  if (!/^[A-Za-z0-9._~-]{1,128}$/.test(found)) return false;
  key = found; keep.set(STORED, key);
  return true;
}
function fromLink() {
  const found = take(location.hash.includes("key=") ? location.hash : "");
  if (location.hash) history.replaceState(null, "", location.pathname);
  return found;
}
$("door").addEventListener("submit", event => {
  event.preventDefault();
  if (take($("key").value.trim())) { $("door").hidden = true; wait = 500; connect(); }
  $("key").value = "";
});
addEventListener("hashchange", () => { if (fromLink()) { $("door").hidden = true; connect(); } });

// -- the connection: it comes back by itself ----------------------------------------------------------------------------------
let socket = null, wait = 500, again = 0, opened = false;
function connect() {
  clearTimeout(again);
  if (socket) { socket.onclose = null; socket.close(); }
  if (!key) { $("door").hidden = false; return; }
  const fresh = socket = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/camera/stream`,
    ["live.operator", `live.key.${key}`]);
  opened = false;
  fresh.onopen = () => { opened = true; asked = ""; wait = 500; samples = []; offset = null; $("door").hidden = true; ping(8); word(); };
  fresh.onmessage = event => heard(JSON.parse(event.data));
  fresh.onclose = () => {
    word();
    if (!opened) tried();
    again = setTimeout(connect, wait * (.75 + .5 * Math.random()));
    wait = Math.min(wait * 1.6, 5000);
  };
  word();
}
async function tried() {  // a browser does not say why a WebSocket was refused
  const used = key;
  try {
    const answer = await fetch("/camera/stream", { headers: { Authorization: `Bearer ${used}` } });
    if (answer.status === 401 && used === key) { $("door").hidden = false; asked = "this key is not (or no more) the show's"; word(); }
    if (answer.status === 503) { asked = "as many phones as there may be are cameras already"; word(); }
  } catch { /* the show does not answer at all */ }
}
function heard(told) {
  if ("pong" in told) pong(told.pong, told.time);
  if (told.refused) {
    asked = told.refused === "too many packets at once" ? "" : told.refused;
    if (told.refused === "wrong clock") { samples = []; offset = null; ping(8); asked = ""; }
  }
  if (told.performers) {
    const before = who() || choices().who, names = told.performers;
    $("who").replaceChildren(...["", ...names].map(name => new Option(name || "choose", name)));
    $("who").value = names.includes(before) ? before : names.length === 1 ? names[0] : "";
    if (who() && told.performer !== who()) tell({ performer: who() });
  }
  word();
}
function tell(what) { if (socket && socket.readyState === 1) socket.send(JSON.stringify(what)); }

// -- the show's clock: ping, and believe the quickest answers -------------------------------------------------------------------
let samples = [], offset = null, pinging = 0;
function ping(left) {
  clearTimeout(pinging);
  if (!socket || socket.readyState !== 1) return;
  tell({ ping: mine() });
  pinging = left > 1 ? setTimeout(ping, 150 + 50 * Math.random(), left - 1) : setTimeout(ping, 10000, 4);
}
function pong(sent, there) {
  const now = mine(), trip = now - sent;
  samples = [...samples, { trip, at: there + trip / 2 - now, when: now }].filter(one => now - one.when < 30).slice(-24);
  const best = [...samples].sort((a, b) => a.trip - b.trip).slice(0, Math.max(1, samples.length >> 2));
  offset = best.map(one => one.at).sort((a, b) => a - b)[best.length >> 1];
}

// -- the packet -------------------------------------------------------------------------------------------------------------------
let count = 0;
const clip = (value, low, high) => Math.min(Math.max(Math.round(value), low), high);
function packet(time, aspect, picture, body) {
  const whole = Boolean(picture && body && picture.length === POINTS && body.length === POINTS);
  const data = new DataView(new ArrayBuffer(whole ? HEAD + POINTS * POINT : HEAD));
  data.setUint8(0, 1); data.setUint8(1, whole ? 1 : 0); data.setUint16(2, count = (count + 1) & 0xffff, true);
  data.setFloat64(4, time, true);
  if (!whole) return data.buffer;
  // The model's browser form does not tell how sure it is of a person: shoulders and hips stand for that.
  const sure = [11, 12, 23, 24].reduce((sum, n) => sum + (picture[n].visibility ?? 0), 0) / 4;
  data.setUint8(12, clip(255 * sure, 0, 255)); data.setUint16(13, clip(4096 * aspect, 0, 65535), true);
  for (let n = 0; n < POINTS; n++) {
    const at = HEAD + n * POINT, p = picture[n], b = body[n];
    [8192 * p.x, 8192 * p.y, 1e4 * b.x, 1e4 * b.y, 1e4 * b.z].forEach((value, k) =>
      data.setInt16(at + 2 * k, clip(value, -32767, 32767), true));
    data.setUint8(at + 10, clip(255 * (p.visibility ?? 0), 0, 255));
  }
  return data.buffer;
}

// -- the model ------------------------------------------------------------------------------------------------------------------
let pose = null, loading = null, exact = true, seen = null, last = null, slowSince = 0, told = 0, late = 0;
const results = [];
function load() {
  loading ||= new Promise((resolve, reject) => {
    const script = Object.assign(document.createElement("script"), { src: "/camera/model/pose.js" });
    script.onload = resolve;
    script.onerror = () => { loading = null; script.remove(); reject(new Error("the model could not be loaded; start again")); };
    document.head.append(script);
  }).then(async () => {
    pose = new Pose({ locateFile: name => `/camera/model/${name}` });
    pose.onResults(found => { last = found; });
    configure();
    await pose.initialize();
  });
  return loading;
}
function configure() {
  const chosen = $("model").value;
  if (chosen !== "auto") exact = chosen === "1";
  if (pose) pose.setOptions({ modelComplexity: exact ? 1 : 0, smoothLandmarks: false, enableSegmentation: false,
    minDetectionConfidence: .5, minTrackingConfidence: .5 });
}

// -- the camera -----------------------------------------------------------------------------------------------------------------
let stream = null, run = 0, lock = null;
const who = () => $("who").value;
const choices = () => { try { return JSON.parse(keep.get(CHOICES)) || {}; } catch { return {}; } };
function lamp(open) {
  $("lamp").className = open ? "open" : "";
  $("lamp").querySelector("span").textContent = open ? "camera open" : "camera closed";
  document.title = `${open ? "● " : ""}Camera · ChoreoGraphics Live`;
  $("go").setAttribute("aria-pressed", open);
  $("go").textContent = open ? "Stop the camera" : "Start the camera";
}
const WHY = {
  NotAllowedError: "this browser was not allowed to use the camera: allow it for this page, then start again",
  NotFoundError: "this device has no camera", OverconstrainedError: "this device has no such camera",
  NotReadableError: "the camera cannot be opened: does another program use it?",
};
async function start() {
  trouble = "";
  if (!navigator.mediaDevices) { trouble = "browsers open a camera only on a page that came over https"; return word(); }
  const mineRun = ++run, lens = $("lens").value;
  const size = { width: { ideal: 640 }, height: { ideal: 480 }, frameRate: { ideal: 30 } };
  const which = lens === "front" ? { facingMode: "user" } : lens === "back" ? { facingMode: "environment" } : { deviceId: { exact: lens } };
  let opening = null;
  try {
    opening = await navigator.mediaDevices.getUserMedia({ video: { ...size, ...which }, audio: false });
    if (mineRun !== run) return opening.getTracks().forEach(track => track.stop());
    stream = opening; lamp(true);
    const track = stream.getVideoTracks()[0];
    track.onended = () => { if (stream === opening) { stop(); trouble = "the camera was taken away; start again"; word(); } };
    $("view").className = track.getSettings().facingMode === "environment" ? "" : "mirrored";
    $("video").srcObject = stream;
    await $("video").play();
    seen = null; word(); awake(); lenses();
    await load();
    slowSince = late = 0;
    if (mineRun === run) frames(mineRun);
  } catch (error) {
    if (mineRun !== run) return;
    stop(); trouble = WHY[error.name] || String(error.message || error); word();
  }
}
function stop() {
  run++;
  if (stream) stream.getTracks().forEach(track => track.stop());
  stream = null; seen = null; $("video").srcObject = null; lamp(false); draw(null); $("rate").textContent = "";
  if (lock) { lock.release().catch(() => {}); lock = null; }
  word();
}
async function lenses() {  // the names of cameras are known once one may be opened
  const found = (await navigator.mediaDevices.enumerateDevices()).filter(one => one.kind === "videoinput" && one.deviceId);
  const chosen = $("lens").value;
  $("lens").replaceChildren(new Option("front", "front"), new Option("back", "back"),
    ...(found.length > 1 ? found : []).map((one, n) => new Option(one.label || `camera ${n + 1}`, one.deviceId)));
  $("lens").value = chosen;
  if (!$("lens").value) $("lens").value = "front";
}
async function awake() {
  try { if (stream && navigator.wakeLock && !document.hidden) lock = await navigator.wakeLock.request("screen"); } catch { /* low battery */ }
}
document.addEventListener("visibilitychange", () => { if (!document.hidden) { awake(); ping(8); $("video").play().catch(() => {}); } });

function frames(mineRun) {
  const video = $("video"), next = video.requestVideoFrameCallback
    ? act => video.requestVideoFrameCallback(act) : act => requestAnimationFrame(now => act(now, {}));
  let before = 0;
  const one = async (now, facts) => {
    if (mineRun !== run) return;
    const clock = performance.now(), taken = facts.captureTime;
    // A camera's own time stamp, where the browser has one that can be true.
    const time = (taken > clock - 500 && taken <= clock ? taken : Math.min(now, clock)) / 1000;
    if (clock - before >= FRAME_MS && video.videoWidth) {
      before = clock; last = null;
      try { await pose.send({ image: video }); } catch (error) {
        if (mineRun === run) { stop(); trouble = `the model has failed: ${error.message || error}; start again`; word(); }
        return;
      }
      if (mineRun !== run) return;
      result(time, video.videoWidth / video.videoHeight);
    }
    next(one);
  };
  next(one);
}
function result(time, aspect) {
  const picture = last && last.poseLandmarks, body = last && last.poseWorldLandmarks, now = performance.now();
  const found = Boolean(picture && body);
  late += .1 * (now - 1000 * time - late);
  if (found !== seen) { seen = found; asked = ""; }
  word();
  draw(picture);
  if (socket && socket.readyState === 1 && offset !== null && who() && socket.bufferedAmount < 2000
    && (found || now - told >= NOBODY_MS)) {
    told = now;
    socket.send(packet(time + offset, aspect, picture, body));
  }
  measure(now);
}
function measure(now) {
  results.push(now);
  while (results[0] < now - 2000) results.shift();
  const rate = results.length / Math.max((now - results[0]) / 1000, .5);
  $("rate").textContent = `${rate.toFixed(0)} pictures a second, ${exact ? "exact" : "quick"} model`;
  slowSince = rate < SLOW ? slowSince || now : 0;
  if (slowSince && now - slowSince > SLOW_AFTER && exact && $("model").value === "auto") { exact = false; configure(); slowSince = 0; }
}
function draw(points) {
  const canvas = $("bones"), video = $("video"), pen = canvas.getContext("2d");
  if (canvas.width !== video.videoWidth || canvas.height !== video.videoHeight) {  // also when the device is turned
    canvas.width = video.videoWidth; canvas.height = video.videoHeight;
  }
  pen.clearRect(0, 0, canvas.width, canvas.height);
  if (!points) return;
  const thick = Math.max(canvas.width, canvas.height) / 160, at = n => [points[n].x * canvas.width, points[n].y * canvas.height];
  pen.lineWidth = thick; pen.lineCap = "round"; pen.strokeStyle = "#e0a33e"; pen.fillStyle = "#fff";
  for (const [a, b] of BONES) {
    pen.globalAlpha = Math.min(points[a].visibility ?? 1, points[b].visibility ?? 1) > .5 ? 1 : .3;
    pen.beginPath(); pen.moveTo(...at(a)); pen.lineTo(...at(b)); pen.stroke();
  }
  for (let n = 11; n < POINTS; n++) { pen.globalAlpha = 1; pen.beginPath(); pen.arc(...at(n), thick, 0, 7); pen.fill(); }
}

// -- the controls ---------------------------------------------------------------------------------------------------------------
const save = () => keep.set(CHOICES, JSON.stringify({ who: who(), lens: $("lens").value, model: $("model").value }));
$("go").addEventListener("click", () => { if (stream) stop(); else start(); });
$("who").addEventListener("change", () => { asked = ""; save(); if (who()) tell({ performer: who() }); word(); });
$("lens").addEventListener("change", () => { save(); if (stream) { stop(); start(); } });
$("model").addEventListener("change", () => { exact = true; configure(); save(); });
addEventListener("pagehide", stop);
for (const [id, name] of [["lens", "lens"], ["model", "model"]])
  if ([...$(id).options].some(option => option.value === choices()[name])) $(id).value = choices()[name];
if (!fromLink()) key = keep.get(STORED);
lamp(false);
connect();
