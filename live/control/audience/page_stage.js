// The surface of the phone: the stage with its dancers and elements, the finger, and the frame loop. It follows page.js.
// -- the dancers: a light each, which moves to where the last frame says until the next one comes ----------------------
const FADE = 6, JUMP = 0.25, STALE = 3, NEAR = 0.13;
let colours = [], places = [], elements = [], stageAt = -9;
function stage(data) {
  const now = mine(), every = data.getUint8(1) / 100, count = data.getUint8(2);
  const share = at => data.getUint8(at) / 255 * 1.25 - 0.125;
  let at = 4;
  for (let i = 0; i < count; i++, at += 3) {
    const group = data.getUint8(at + 2), x = share(at), z = share(at + 1), old = places[i];
    if (!group) { if (old) old.there = false; continue }
    const from = old && old.there ? position(old, now) : [x, z];
    const same = old && old.there && Math.hypot(x - from[0], z - from[1]) < JUMP;
    places[i] = { from: same ? from : [x, z], to: [x, z], at: now, every: 1.1 * every, group, there: true, level: same ? old.level : 0 };
  }
  for (let i = count; i < places.length; i++) places[i].there = false;
  elements = [];
  for (let i = data.getUint8(3); i > 0; i--) {
    const points = [], [shape, level, radius, many] = [0, 1, 2, 3].map(k => data.getUint8(at + k));
    for (at += 4; points.length < many; at += 2) points.push([share(at), share(at + 1)]);
    elements.push({ shape, level: level / 255, radius: radius / 255, points });
  }
  stageAt = now;
}
function position(one, now) {
  const t = Math.min((now - one.at) / one.every, 1);
  return [0, 1].map(k => one.from[k] + (one.to[k] - one.from[k]) * t);
}
const sprites = {};
function sprite(colour) {  // drawn once for each colour
  if (!sprites[colour]) {
    const made = sprites[colour] = document.createElement("canvas"), pen = made.getContext("2d"), c = 32;
    made.width = made.height = 2 * c;
    const glow = pen.createRadialGradient(c, c, 0, c, c, c);
    glow.addColorStop(0, "#fff"); glow.addColorStop(0.1, "#fff"); glow.addColorStop(0.24, colour);
    glow.addColorStop(0.4, colour + "66"); glow.addColorStop(1, colour + "00");
    pen.fillStyle = glow; pen.fillRect(0, 0, 2 * c, 2 * c);
  }
  return sprites[colour];
}

// -- the surface: the stage in perspective, as from a seat --------------------------------------------------------------
const canvas = $("stage"), ctx = canvas.getContext("2d"), FAR = 0.7, INSET = 0.06;
const edge = () => Math.max(INSET, 24 / Math.max(canvas.clientHeight, 60));
let touch = null, wish = 1, sentAt = 0, sendTimer = 0, nearTimer = 0, cursor = { x: 0.5, z: 0.6 };
function inside(event) {
  const box = canvas.getBoundingClientRect();
  const u = (event.clientX - box.left) / box.width, v = (event.clientY - box.top) / box.height;
  const down = Math.min(Math.max((v - edge()) / (1 - 2 * edge()), 0), 1), wide = FAR + (1 - FAR) * down;
  return { x: Math.min(Math.max((u - 0.5) / (wide * (1 - 2 * INSET)) + 0.5, 0), 1), z: (1 - FAR / wide) / (1 - FAR) };
}
const width = z => FAR / (1 - (1 - FAR) * z);
function outside(x, z) {
  const wide = width(z), down = (wide - FAR) / (1 - FAR);
  return [(0.5 + (x - 0.5) * wide * (1 - 2 * INSET)) * canvas.width, (edge() + down * (1 - 2 * edge())) * canvas.height];
}
function down(event) {
  if (touch) return;
  event.preventDefault();
  try { canvas.setPointerCapture(event.pointerId) } catch { /* a pointer that is gone already */ }
  touch = { id: event.pointerId, ...inside(event), mode: wish, px: event.clientX, py: event.clientY, since: mine() };
  touch.hold = setTimeout(() => { if (touch && !touch.moved) { touch.mode = 3 - wish; buzz(); send() } }, 550);
  send();
}
function move(event) {
  if (!touch || event.pointerId !== touch.id) return;
  Object.assign(touch, inside(event));
  if (Math.hypot(event.clientX - touch.px, event.clientY - touch.py) > 12) touch.moved = true;
  send();
}
function lift(event) {
  if (!touch || (event && event.pointerId !== touch.id)) return;
  clearTimeout(touch.hold);
  touch = null; sentAt = 0; send();
}
canvas.addEventListener("pointerdown", down);
canvas.addEventListener("pointermove", move);
for (const each of ["pointerup", "pointercancel", "lostpointercapture"]) canvas.addEventListener(each, lift);
canvas.addEventListener("contextmenu", event => event.preventDefault());
canvas.addEventListener("keydown", event => {
  const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
  if (step) {
    cursor = { x: Math.min(Math.max(cursor.x + 0.04 * step[0], 0), 1), z: Math.min(Math.max(cursor.z + 0.04 * step[1], 0), 1) };
    if (touch) Object.assign(touch, cursor);
    clearTimeout(nearTimer); nearTimer = setTimeout(near, 500);
  } else if (event.key === " ") {
    if (touch) lift(); else touch = { id: "key", ...cursor, mode: wish, since: mine() };
  } else return;
  event.preventDefault(); send();
});
function near() {  // for a screen reader: how many dancers are about the cursor
  const now = mine();
  const n = places.filter(one => one.there && Math.hypot(...position(one, now).map((v, k) => v - (k ? cursor.z : cursor.x))) < NEAR).length;
  put("near", fill(say.near[Math.min(n, 2)], { n }));
}
function buzz() { try { navigator.vibrate && !calm.matches && navigator.vibrate(25) } catch { /* never mind */ } }
function send() {
  clearTimeout(sendTimer);
  const every = me ? me.every : 100, wait = sentAt + every - 1000 * mine();
  if (!open() || !me) return;
  if (wait > 0) { sendTimer = setTimeout(send, wait); return }
  const data = new DataView(new ArrayBuffer(6));
  data.setUint8(0, 1); data.setUint8(1, touch ? touch.mode : 0);
  data.setUint16(2, touch ? Math.round(touch.x * 65535) : 0, true);
  data.setUint16(4, touch ? Math.round(touch.z * 65535) : 0, true);
  socket.send(data.buffer);
  sentAt = 1000 * mine();
  if (touch) sendTimer = setTimeout(send, Math.max(300, every));
}
for (const [id, mode] of [["come", 1], ["go", 2]]) $(id).onclick = () => {
  wish = mode;
  $("come").setAttribute("aria-pressed", mode === 1); $("go").setAttribute("aria-pressed", mode === 2);
  if (touch) { touch.mode = mode; send() }
};

// -- pictures -------------------------------------------------------------------------------------------------------------
let drawnAt = 0;
function draw() {
  const now = beat(), w = canvas.clientWidth, h = canvas.clientHeight, fine = Math.min(devicePixelRatio || 1, 2);
  if (canvas.width !== Math.round(w * fine) || canvas.height !== Math.round(h * fine)) {
    canvas.width = Math.round(w * fine); canvas.height = Math.round(h * fine);
  }
  const phase = now === null ? 1 : now - Math.floor(now), pulse = calm.matches ? 0.3 : Math.max(0, 1 - 3 * phase);
  let on = -1;
  if (now !== null) {
    const size = clock[3];
    on = Math.floor((((now - clock[4]) % size) + size) % size);
  }
  [...$("beats").children].forEach((dot, i) => dot.classList.toggle("now", i === on && (calm.matches || phase < 0.6)));
  count(now);
  ctx.clearRect(0, 0, canvas.width, canvas.height);
  floor(pulse, fine);
  if (!why && state && state.open) { marks(calm.matches ? 0.5 : phase, fine); dancers(fine) }
  finger(pulse, fine);
  requestAnimationFrame(draw);
}
function floor(pulse, fine) {
  const closed = why || (state && !state.open);
  ctx.beginPath();
  for (const [x, z] of [[0, 0], [1, 0], [1, 1], [0, 1]]) ctx.lineTo(...outside(x, z));
  ctx.closePath();
  ctx.fillStyle = closed ? "#101119" : `rgb(${20 + 16 * pulse},${22 + 16 * pulse},${34 + 22 * pulse})`;
  ctx.fill();
  ctx.lineWidth = 1.5 * fine; ctx.strokeStyle = closed ? "#2a2c3a" : "#4a4e68"; ctx.stroke();
  ctx.beginPath();
  for (let i = 1; i < 8; i++) { ctx.moveTo(...outside(i / 8, 0)); ctx.lineTo(...outside(i / 8, 1)) }
  for (let i = 1; i < 6; i++) { ctx.moveTo(...outside(0, i / 6)); ctx.lineTo(...outside(1, i / 6)) }
  ctx.lineWidth = fine; ctx.globalAlpha = 0.25; ctx.stroke(); ctx.globalAlpha = 1;
  ctx.fillStyle = "#b4b6c6"; ctx.textAlign = "center"; ctx.font = `${13 * fine}px system-ui, sans-serif`;
  ctx.fillText(say.back, canvas.width / 2, outside(0.5, 0)[1] - 6 * fine);
  ctx.fillText(say.front, canvas.width / 2, Math.min(outside(0.5, 1)[1] + 17 * fine, canvas.height - 3 * fine));
}
const GATHER = 1, LEAVE = 2, SPREAD = 3, CROSS = 4, GO = 5;
function marks(phase, fine) {  // what moves the dancers: rings that close or open, lines, and arrows
  ctx.strokeStyle = "#ffd58a"; ctx.lineWidth = 2 * fine; ctx.lineCap = "round";
  for (const { shape, level, radius, points } of elements) {
    const ring = (x, z, size, alpha) => {
      const [px, py] = outside(x, z), r = size * width(z) * (1 - 2 * INSET) * canvas.width;
      ctx.globalAlpha = alpha * level; ctx.beginPath(); ctx.ellipse(px, py, r, 0.55 * r, 0, 0, 7); ctx.stroke();
    };
    const [x, z] = points[0] || [0.5, 0.5], size = Math.max(radius, 0.07), far = points[points.length - 1];
    if (shape === SPREAD) for (const k of [0, 0.5]) ring(0.5, 0.5, 0.12 + 0.3 * ((phase / 2 + k) % 1), 0.4 * (1 - (phase / 2 + k) % 1));
    else if (points.length > 1) {
      ctx.globalAlpha = 0.6 * level;
      ctx.setLineDash(shape === CROSS ? [7 * fine, 7 * fine] : []);
      ctx.beginPath(); points.forEach(point => ctx.lineTo(...outside(...point))); ctx.stroke();
      ctx.setLineDash([]);
      if (shape === GO) arrow(points[points.length - 2], far, fine);
    } else if (shape === GATHER) { ring(x, z, size, 0.55); ring(x, z, size * (1.9 - 0.8 * phase), 0.35 * phase) }
    else if (shape === LEAVE) { ctx.setLineDash([6 * fine, 6 * fine]); ring(x, z, size, 0.6); ring(x, z, size * (1.1 + 0.8 * phase), 0.4 * (1 - phase)); ctx.setLineDash([]) }
    else { ring(x, z, size, 0.5); ring(x, z, 1.6 * size, 0.3) }
  }
  ctx.globalAlpha = 1;
}
function arrow(from, to, fine) {
  const [ax, ay] = outside(...from), [x, y] = outside(...to), turn = Math.atan2(y - ay, x - ax);
  ctx.beginPath();
  for (const side of [2.6, 0, -2.6]) side ? ctx.lineTo(x + 11 * fine * Math.cos(turn + side), y + 11 * fine * Math.sin(turn + side)) : ctx.lineTo(x, y);
  ctx.stroke();
}
function dancers(fine) {
  const now = mine(), passed = Math.min(now - drawnAt, 0.1), fresh = now - stageAt < STALE ? 1 : 0.35;
  const base = Math.min(Math.max(Math.min(0.055 * canvas.width, 0.12 * canvas.height), 9 * fine), 24 * fine);
  drawnAt = now;
  ctx.globalCompositeOperation = "lighter";
  for (const one of places) {
    one.level += ((one.there ? 1 : 0) - one.level) * Math.min(1, FADE * passed);
    if (one.level < 0.02) continue;
    const [x, z] = position(one, now), [px, py] = outside(x, z), r = base * width(z);
    ctx.globalAlpha = fresh * one.level;
    ctx.drawImage(sprite(colours[(one.group - 1) % (colours.length || 1)] || "#ffffff"), px - r, py - r, 2 * r, 2 * r);
  }
  ctx.globalCompositeOperation = "source-over"; ctx.globalAlpha = 1;
}
function finger(pulse, fine) {  // bright once the show has heard it, grey while it does not count
  const at = touch || (document.activeElement === canvas && canvas.matches(":focus-visible") ? { ...cursor, mode: 0 } : null);
  if (!at) return;
  const [x, y] = outside(at.x, at.z), heard = hearing === HEARD || hearing === SEEN, mute = hearing === WAITS || hearing === NONE;
  ctx.strokeStyle = ctx.fillStyle = mute ? "#9a9cab" : me ? me.colour : "#8fd0ff";
  const r = (34 + (heard ? 12 * pulse : 0)) * fine, ring = (a, b) => { ctx.beginPath(); ctx.ellipse(x, y, a, b, 0, 0, 7) };
  if (heard && at.mode) {
    const glow = ctx.createRadialGradient(x, y, 0, x, y, 2 * r);
    glow.addColorStop(0, ctx.fillStyle); glow.addColorStop(1, "transparent");
    ctx.save(); ctx.globalAlpha = hearing === SEEN ? 0.8 : 0.5; ctx.fillStyle = glow; ring(2 * r, 1.4 * r); ctx.fill(); ctx.restore();
  }
  ctx.lineWidth = (heard ? 4 : 2.5) * fine; ctx.globalAlpha = heard || !at.mode ? 1 : 0.55;
  ring(r, r * 0.7);
  if (at.mode === 1) { const was = ctx.globalAlpha; ctx.globalAlpha = 0.3 * was; ctx.fill(); ctx.globalAlpha = was }
  if (mute) ctx.setLineDash([3 * fine, 8 * fine]);
  ctx.stroke();
  if (at.mode === 2) { ring(r * 1.5, r * 1.05); ctx.setLineDash([9 * fine, 9 * fine]); ctx.stroke() }
  ctx.setLineDash([]);
  if (hearing === SEEN && at.mode) { ctx.fillStyle = "#fff"; ring(7 * fine, 5 * fine); ctx.fill() }
  ctx.globalAlpha = 1;
}
window.live = {
  beat, showTime, me: () => me, state: () => state, lit: () => hearing === SEEN, hearing: () => hearing, why: () => why,
  dancers: () => places.filter(one => one.there).map(one => [...position(one, mine()), one.group]), elements: () => elements,
  tally: () => tally, ready: () => !!(me && clock && series.length > 3),
};
words();
requestAnimationFrame(draw);
setTimeout(connect, 250 * Math.random());
