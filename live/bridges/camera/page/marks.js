// The page of `live calibrate camera`. It shows pictures and takes clicks; which camera they give, and the grid that is drawn,
// the program works out (live/bridges/camera/floor_marks.py).
const $ = id => document.getElementById(id);
const STORED = "live.marks.key", EVERY_MS = 1000, ZOOM = 5, SVG = "http://www.w3.org/2000/svg";
const CORNERS = ["upper left", "upper right", "lower right", "lower left"], SHORT = ["UL", "UR", "LR", "LL"];

let key = "", socket = null, facts = null, points = [], turn = 0, number = 0, size = [0, 0], url = "";
let touched = false, asking = false, checking = false, again = false, good = false, saved = false, trouble = "", problem = "";

// -- words ------------------------------------------------------------------------------------------------------------
const metres = value => `${+Math.abs(value).toFixed(2)} m`;
function placeWords([x, z]) {
  const across = x === 0 ? [] : [`${metres(x)} to the audience's ${x < 0 ? "left" : "right"}`];
  const along = z === 0 ? [] : [`${metres(z)} towards the ${z > 0 ? "audience" : "back"}`];
  return [...across, ...along].join(" and ") || "0 m away";
}
const nameOf = point => point.kind === "mark" ? `Mark ${point.index + 1}` : `Screen, ${CORNERS[point.index]}`;
const marks = () => points.filter(point => point.kind === "mark");
const corners = () => points.filter(point => point.kind === "corner");
const isOpen = () => socket !== null && socket.readyState === 1;
function next() {
  const free = marks().find(point => !point.at);
  if (free) return free;
  const some = corners().some(point => point.at);
  return $("corners").open || some ? corners().find(point => !point.at) : undefined;
}
function say() {
  const wanted = next();
  let text = "", wrong = true;
  if (saved) return;
  if (!isOpen()) text = "The program does not answer. Is the command still running?";
  else if (trouble) text = trouble;
  else if (!number) { text = "Waiting for the first picture …"; wrong = false; }
  else if (problem) text = problem;
  else if (wanted && wanted.kind === "mark") {
    const few = marks().length;
    text = `Click mark ${wanted.index + 1} of ${few}. From the stage's centre it is ${placeWords(facts.marks[wanted.index])}.`;
    wrong = false;
  } else if (wanted) { text = `Click the ${CORNERS[wanted.index]} corner of the projected picture.`; wrong = false; }
  else if (good) { text = "Does the green grid lie on the floor, with the white line at the audience's side? Then save."; wrong = false; }
  else { text = $("word").textContent; wrong = false; }  // the answer comes at once
  if ($("word").textContent !== text) $("word").textContent = text;
  $("word").className = wrong ? "wrong" : "";
  const count = corners().filter(point => point.at).length;
  $("save").disabled = !(isOpen() && good && !checking && (count === 0 || count === 4));
}

// -- drawing ----------------------------------------------------------------------------------------------------------
function make(parent, name, attributes = {}, text = "") {
  const made = document.createElementNS(SVG, name);
  for (const [each, value] of Object.entries(attributes)) made.setAttribute(each, value);
  if (text) made.textContent = text;
  parent.append(made);
  return made;
}
function drawPlan() {
  const plan = $("plan"), reach = Math.max(...facts.marks.flat().map(Math.abs), .5);
  plan.setAttribute("viewBox", "-50 -22 100 48");
  plan.replaceChildren();
  const at = ([x, z]) => [x / reach * 17, z / reach * 17];
  make(plan, "polygon", { points: facts.marks.map(each => at(each).join(",")).join(" ") });
  make(plan, "path", { d: "M-2 0H2M0 -2V2" });
  marks().forEach(point => {
    const group = make(plan, "g", { class: point === next() ? "next" : point.at ? "placed" : "" }), [x, y] = at(facts.marks[point.index]);
    make(group, "circle", { cx: x, cy: y, r: 2.8 });
    make(group, "text", { x, y }, String(point.index + 1));
  });
  make(plan, "text", { x: 0, y: 23.5, class: "audience" }, "audience");
}
function drawGrid(told) {
  const grid = $("grid");
  grid.replaceChildren();
  for (const note of document.querySelectorAll(".note")) note.remove();
  if (!told) return;
  const draw = (line, kind) => make(grid, "line", { x1: line[0][0], y1: line[0][1], x2: line[1][0], y2: line[1][1], class: kind });
  told.lines.forEach(line => draw(line, ""));
  if (told.audience) {
    draw(told.audience, "audience");
    note("audience", [0, 1].map(axis => (told.audience[0][axis] + told.audience[1][axis]) / 2));
  }
  if (told.centre) note("centre", told.centre);
  const seen = corners().map(point => point.at);
  if (seen.every(Boolean)) make(grid, "polygon", { points: seen.map(at => at.join(",")).join(" ") });
}
function note(text, [u, v]) {
  if (u < 0 || u > 1 || v < 0 || v > .92) return;
  const made = document.createElement("span");
  made.className = "note"; made.textContent = text; made.setAttribute("aria-hidden", "true");
  made.style.left = `${100 * u}%`; made.style.top = `${100 * v}%`;
  $("points").append(made);
}
const percent = value => (100 * value).toFixed(2);
function show() {
  const wanted = next();
  for (const point of points) {
    const { button, row, left, top, at } = point;
    button.hidden = !at;
    row.className = point === wanted ? "next" : "";
    if (at) {
      button.style.left = `${100 * at[0]}%`; button.style.top = `${100 * at[1]}%`;
      button.setAttribute("aria-label", `${nameOf(point)}: ${percent(at[0])} % from the left, ${percent(at[1])} % from the top`);
    }
    if (document.activeElement !== left) left.value = at ? percent(at[0]) : "";
    if (document.activeElement !== top) top.value = at ? percent(at[1]) : "";
  }
  drawPlan();
  say();
}
function magnify(at) {
  const glass = $("glass"), image = $("picture");
  glass.hidden = !at || !image.naturalWidth;
  if (glass.hidden) return;
  const brush = glass.getContext("2d"), [width, height] = size, half = glass.width / 2;
  brush.imageSmoothingEnabled = false;
  brush.fillStyle = "#000";
  brush.fillRect(0, 0, glass.width, glass.height);
  brush.drawImage(image, half - at[0] * width * ZOOM, half - at[1] * height * ZOOM, width * ZOOM, height * ZOOM);
  brush.strokeStyle = "#fff"; brush.lineWidth = 3; cross();
  brush.strokeStyle = "#000"; brush.lineWidth = 1; cross();
  function cross() {
    brush.beginPath();
    for (const [x, y] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
      brush.moveTo(half + 6 * x, half + 6 * y); brush.lineTo(half + 60 * x, half + 60 * y);
    }
    brush.stroke();
  }
  glass.style.left = at[0] < .5 ? "auto" : "8px"; glass.style.right = at[0] < .5 ? "8px" : "auto";
  glass.style.top = "8px";
}

// -- clicks, drags, keys ------------------------------------------------------------------------------------------------
const within = value => Math.min(Math.max(value, 0), 1);
function place(point, u, v) {
  point.at = [within(u), within(v)];
  touched = true;
  changed();
}
function changed() {
  good = false; problem = "";
  show();
  check();
}
function fromEvent(event) {
  const box = $("picture").getBoundingClientRect();
  return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
}
let dragged = null, offset = [0, 0];
$("view").addEventListener("pointerdown", event => {
  if (!number || saved || event.button !== 0) return;
  const at = fromEvent(event), held = points.find(point => point.button === event.target.closest(".point"));
  dragged = held || next();
  if (!dragged) return;
  event.preventDefault();
  offset = held ? [held.at[0] - at[0], held.at[1] - at[1]] : [0, 0];
  $("view").setPointerCapture(event.pointerId);
  if (!held) place(dragged, ...at);
  dragged.button.focus();
  magnify(dragged.at);
});
$("view").addEventListener("pointermove", event => {
  if (!number || saved) return;
  const at = fromEvent(event);
  if (dragged) { place(dragged, at[0] + offset[0], at[1] + offset[1]); magnify(dragged.at); }
  else magnify(event.pointerType === "mouse" && next() ? at : null);
});
for (const kind of ["pointerup", "pointercancel"]) $("view").addEventListener(kind, () => { dragged = null; });
$("view").addEventListener("pointerleave", () => { if (!dragged) magnify(null); });
function onKey(point, event) {
  const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
  if (way && point.at && !saved) {
    event.preventDefault();
    const step = event.shiftKey ? 10 : .5;
    place(point, point.at[0] + step * way[0] / size[0], point.at[1] + step * way[1] / size[1]);
    magnify(point.at);
  } else if (event.key === "Delete" && !saved) {
    point.at = null; magnify(null); changed(); point.put.focus();
  }
}
function addPoint(kind, index, at) {
  const point = { kind, index, at };
  const button = point.button = document.createElement("button");
  button.className = `point ${kind}`;
  button.type = "button";
  const label = document.createElement("b");
  label.textContent = kind === "mark" ? String(index + 1) : SHORT[index];
  button.append(label);
  button.addEventListener("keydown", event => onKey(point, event));
  button.addEventListener("focus", () => point.at && magnify(point.at));
  button.addEventListener("blur", () => dragged || magnify(null));
  $("points").append(button);
  const row = point.row = document.createElement("li"), words = document.createElement("span");
  words.textContent = kind === "mark" ? `${index + 1}: x ${facts.marks[index][0]}, z ${facts.marks[index][1]}` : CORNERS[index];
  row.append(words);
  for (const [axis, side] of [["left", "from the left"], ["top", "from the top"]]) {
    const input = point[axis] = document.createElement("input");
    Object.assign(input, { type: "number", min: 0, max: 100, step: .01, placeholder: axis === "left" ? "← %" : "↑ %" });
    input.setAttribute("aria-label", `${nameOf(point)}: per cent ${side}`);
    input.addEventListener("change", () => {
      const [u, v] = [point.left.value, point.top.value].map(text => text === "" ? NaN : Number(text) / 100);
      if (Number.isFinite(u) && Number.isFinite(v) && number) { place(point, u, v); magnify(null); }
    });
    row.append(input);
  }
  const put = point.put = document.createElement("button");
  put.type = "button"; put.textContent = "Place";
  put.setAttribute("aria-label", `Place ${nameOf(point).toLowerCase()} with the keys`);
  put.addEventListener("click", () => {
    if (!number) return;
    if (!point.at) place(point, .5, .5);
    point.button.focus();
  });
  row.append(put);
  $(kind === "mark" ? "list" : "screen").append(row);
  points.push(point);
}
function begin() {
  points = [];
  for (const id of ["list", "screen", "points"]) $(id).replaceChildren();
  facts.marks.forEach((_, index) => addPoint("mark", index, facts.places[index] ?? null));
  CORNERS.forEach((_, index) => addPoint("corner", index, facts.screen[index] ?? null));
  $("corners").open = facts.screen.length > 0;
  document.title = `Marks of ${facts.name} · ChoreoGraphics Live`;
  $("where").textContent = facts.where;
}
$("fresh").addEventListener("click", ask);
$("turn").addEventListener("click", () => { turn = (turn + 90) % 360; number = 0; clear(); ask(); });
$("clear").addEventListener("click", () => { clear(); ask(); });
$("none").addEventListener("click", () => { for (const point of corners()) point.at = null; $("corners").open = false; touched = true; changed(); });
$("corners").addEventListener("toggle", () => facts && show());
$("save").addEventListener("click", () => send("save"));
function clear() {
  for (const point of points) point.at = null;
  touched = false;
  drawGrid(null); magnify(null); $("found").textContent = "";
  changed();
}

// -- the program --------------------------------------------------------------------------------------------------------
function send(kind, more = {}) {
  if (!isOpen()) return false;
  const at = list => list.every(point => point.at) ? list.map(point => point.at) : [];
  socket.send(JSON.stringify(kind === "picture" ? { kind, turn, ...more } : { kind, turn, places: at(marks()), screen: at(corners()) }));
  return true;
}
function ask() {
  if (!asking && !saved) asking = send("picture", { after: number });
}
function check() {
  if (!marks().every(point => point.at)) { drawGrid(null); $("found").textContent = ""; return; }
  if (checking) { again = true; return; }
  checking = number > 0 && send("check");
}
function heard(told) {
  if (told.kind === "none") {
    asking = false; trouble = `The camera shows nothing: ${told.problem}.`;
    say(); setTimeout(ask, EVERY_MS);
  } else if (told.kind === "picture") {
    waiting = told;
  } else if (told.kind === "checked") {
    checking = false;
    if (again) { again = false; check(); return; }
    if (!marks().every(point => point.at)) return;
    good = !told.problem;
    problem = good ? "" : told.problem + (told.remedy ? `: ${told.remedy}` : "") + ".";
    drawGrid(good ? told : null);
    $("found").textContent = good ? `The camera stands ${told.camera_height} m over the floor, ${placeWords([told.camera_x, told.camera_z])} `
      + `from the stage's centre. The marks fit within ${Math.max(told.off_percent, .1)} % of the picture's height. A square of the grid is ${told.step} m wide.` : "";
    show();
  } else if (told.kind === "saved") {
    saved = true;
    $("word").textContent = `${told.words} You can close this page.`; $("word").className = "";
    for (const each of document.querySelectorAll("button, input")) each.disabled = true;
    magnify(null);
  } else if (told.kind === "refused") {
    checking = false;
    problem = told.problem + (told.remedy ? `: ${told.remedy}` : "") + ".";
    say();
  }
}
let waiting = null;
function picture(data) {
  const told = waiting;
  asking = false;
  if (!told || told.turn !== turn) { ask(); return; }
  const image = $("picture"), fresh = URL.createObjectURL(new Blob([data], { type: "image/jpeg" }));
  image.onload = () => {
    if (url) URL.revokeObjectURL(url);
    url = fresh; number = told.number; size = told.size; trouble = "";
    $("view").style.setProperty("--aspect", size[0] / size[1]);
    $("camera").textContent = `${facts.camera}, ${size[0]} × ${size[1]}`;
    if (!good && !checking && !problem) check();
    say();
    setTimeout(() => { if (!touched && !document.hidden) ask(); }, EVERY_MS);
  };
  image.onerror = () => { URL.revokeObjectURL(fresh); trouble = "The picture cannot be shown."; say(); setTimeout(ask, EVERY_MS); };
  image.src = fresh;
}
document.addEventListener("visibilitychange", () => { if (facts && !touched) ask(); });
function connect() {
  const opened = socket = new WebSocket(`ws://${location.host}/marks/words`, ["live.operator", `live.key.${key}`]);
  opened.binaryType = "arraybuffer";
  opened.onopen = () => { asking = checking = false; ask(); say(); };
  opened.onmessage = event => typeof event.data === "string" ? heard(JSON.parse(event.data)) : picture(event.data);
  opened.onclose = () => { if (!saved) { say(); setTimeout(start, EVERY_MS); } };
}
async function start() {
  try {
    const answer = await fetch("/surface.json", { headers: { Authorization: `Bearer ${key}` } });
    if (answer.status === 401 || answer.status === 429) { $("door").hidden = false; document.querySelector("main").hidden = true; return; }
    const told = await answer.json();
    $("door").hidden = true; document.querySelector("main").hidden = false;
    if (!facts) { facts = told; turn = facts.turn; begin(); show(); }
    connect();
  } catch { if (facts) say(); setTimeout(start, EVERY_MS); }
}
function take(text) {
  const found = text.includes("key=") ? text.split("key=")[1].split("&")[0] : text;
  if (!/^[A-Za-z0-9._~-]{1,128}$/.test(found)) return;
  key = found;
  try { sessionStorage.setItem(STORED, key); } catch { /* while this page is open */ }
}
$("door").addEventListener("submit", event => { event.preventDefault(); take($("key").value.trim()); $("key").value = ""; start(); });
try { key = sessionStorage.getItem(STORED) ?? ""; } catch { /* none */ }
if (location.hash.includes("key=")) take(location.hash);
if (location.hash) history.replaceState(null, "", location.pathname);
if (key) start(); else { $("door").hidden = false; document.querySelector("main").hidden = true; }
