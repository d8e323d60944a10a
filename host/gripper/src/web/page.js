"use strict";
// The live page. The server sends `setup` (finger, object, settings: what the target has acknowledged), `frame` (30 a second)
// and `notice`; what is asked of the target goes back as POST /command and is answered by the target's own answer.
const $ = id => document.getElementById(id);
const token = new URLSearchParams(location.hash.slice(1)).get("token");
const WINDOW = 20; // seconds of the charts
const GAP = 0.3; // seconds without reports that leave a gap in a chart
const APART = 8; // mm between contacts that are not one stretch
const cards = [];
let setup = null, frame = null, heard = 0, dirty = true;

// ---- light and dark
const root = document.documentElement;
const dark = matchMedia("(prefers-color-scheme: dark)");
let chosen = null;
try { chosen = localStorage.getItem("theme"); } catch { /* storage is off: the system's choice */ }
let ink = {};
function theme() {
  root.classList.toggle("dark", chosen ? chosen === "dark" : dark.matches);
  const style = getComputedStyle(root);
  ink = Object.fromEntries(["main", "muted", "faint", "ghost", "object", "objectedge", "front", "back", "lamella", "force", "angle", "goal", "bad", "card"]
    .map(name => [name, style.getPropertyValue("--" + name).trim()]));
  dirty = true;
}
function turnTheme() {
  chosen = root.classList.contains("dark") ? "light" : "dark";
  try { localStorage.setItem("theme", chosen); } catch { /* for this visit only */ }
  theme();
}
dark.addEventListener("change", theme);
$("theme").addEventListener("click", turnTheme);

// ---- asking the target
let stopping = null; // a stop that the target has not taken
async function send(command, patience) {
  const headers = { "content-type": "application/json" };
  if (token) headers["x-token"] = token;
  const signal = patience ? AbortSignal.timeout(patience) : undefined;
  const answer = await fetch("/command", { method: "POST", headers, body: JSON.stringify(command), signal });
  return answer.json();
}
async function ask(command, output) {
  const say = (words, kind) => {
    // A stop that is not taken yet stays on the screen.
    if (stopping && output === $("answer")) return;
    output.textContent = words;
    output.className = kind;
  };
  say("sent …", "");
  try {
    const told = await send(command);
    say(told.words, told.ok ? "good" : "bad");
    return told.ok;
  } catch (error) {
    say("not sent: " + error.message, "bad");
    return false;
  }
}
const which = () => cards.length > 1 && $("finger").value !== "all" ? Number($("finger").value) : null;
// What a person has typed that cannot be sent, in a sentence.
class Wrong extends Error {}
const label = input => input.closest("label").firstChild.textContent.trim();
const number = input => {
  const text = input.value.trim().replace(",", ".");
  const value = Number(text);
  if (text === "" || !Number.isFinite(value)) throw new Wrong(`${label(input)}: “${input.value}” is not a number. Nothing was sent.`);
  if (input.inputMode === "numeric" && !Number.isInteger(value)) throw new Wrong(`${label(input)}: ${value} is not a whole number. Nothing was sent.`);
  return value;
};
// Asks what `command` makes of the fields, unless one of them is wrong.
function askWith(command, output) {
  let made;
  try {
    made = command();
  } catch (error) {
    if (!(error instanceof Wrong)) throw error;
    output.textContent = error.message;
    output.className = "bad";
    return;
  }
  ask(made, output);
}
// All fingers, at once, and again ten times a second until the target has taken it. A browser has six connections to a server: most
// attempts are given up soon, one in fifty waits for a slow target.
function stop() {
  if (stopping) return;
  const own = stopping = { since: performance.now(), count: 0, refused: false, why: "the target does not answer" };
  const attempt = async () => {
    const patience = own.count++ % 50 ? 350 : 5000;
    try {
      const told = await send("stop", patience);
      if (stopping !== own) return;
      if (told.ok) {
        clearInterval(own.timer);
        stopping = null;
        $("stop").classList.remove("sent");
        answer(told.words, "good");
        return;
      }
      [own.refused, own.why] = [true, told.words.replace(/^NOT STOPPED: /, "")];
    } catch (error) {
      if (error.name !== "TimeoutError" && error.name !== "AbortError") own.why = "not sent: " + error.message;
    }
    notStopped();
  };
  $("stop").classList.add("sent");
  answer("stopping …", "");
  own.timer = setInterval(attempt, 100);
  attempt();
}
// Says that a stop was not taken, from its first second on, until it is.
function notStopped() {
  if (!stopping) return;
  const late = (performance.now() - stopping.since) / 1000;
  if (late >= 0.9 || stopping.refused) answer(`NOT STOPPED for ${late.toFixed(1)} s: ${stopping.why}. Still trying.`, "bad");
}
function answer(words, kind) {
  const output = $("answer");
  if (output.textContent !== words) output.textContent = words;
  output.className = kind;
}
const grip = () => askWith(() => ({ grip: { force_n: number($("force")) } }), $("answer"));
const release = () => ask({ release: {} }, $("answer"));
$("stop").addEventListener("click", stop);
$("release").addEventListener("click", release);
$("relax").addEventListener("click", () => ask({ relax: {} }, $("answer")));
$("resume").addEventListener("click", () => ask("resume", $("answer")));
$("grip-form").addEventListener("submit", event => { event.preventDefault(); grip(); });
$("close-form").addEventListener("submit", event => {
  event.preventDefault();
  askWith(() => ({ close: { angle_deg: number($("angle")) } }), $("answer"));
});
addEventListener("keydown", event => {
  const typing = event.target.matches("input, select, textarea");
  if (event.key === "Escape" || (event.key === " " && !typing)) {
    event.preventDefault();
    if (!event.repeat) stop();
  } else if (!typing && !event.repeat && !event.ctrlKey && !event.metaKey && !event.altKey) {
    const key = event.key.toLowerCase();
    if (key === "g") grip(); else if (key === "r") release(); else if (key === "t") turnTheme();
  }
});
// Space on a focused button is a stop as well, not a click.
addEventListener("keyup", event => { if (event.key === " " && event.target.matches("button")) event.preventDefault(); });

// ---- settings
const FRICTION = ["friction", "Friction (coefficient)", 1, "0"];
const FIELDS = {
  "circle": [["radius_mm", "Radius", 1], ["centre_mm", "Centre x, y", 2], FRICTION],
  "ellipse": [["centre_mm", "Centre x, y", 2], ["semi_axes_mm", "Semi-axes a, b", 2], ["angle_deg", "Angle (°)", 1], FRICTION],
  "polygon": [["corners_mm", "Corners x, y; x, y; …", 3], ["rounding_mm", "Rounding", 1], FRICTION],
  "half-plane": [["point_mm", "Point x, y", 2], ["normal", "Normal x, y", 2], FRICTION],
  "bore": [["radius_mm", "Radius", 1], ["centre_mm", "Centre x, y", 2], FRICTION],
};
const objectForm = $("object-form"), limitsForm = $("limits-form");
function objectFields(values) {
  const place = $("object-fields");
  place.replaceChildren();
  for (const [key, words, kind, usual] of FIELDS[objectForm.shape.value]) {
    const label = document.createElement("label"), input = document.createElement("input");
    input.name = key;
    if (kind === 3) input.className = "wide";
    const value = values ? values[key] : undefined;
    input.value = value === undefined ? usual ?? "" : kind === 3 ? value.map(p => p.join(", ")).join("; ") : [].concat(value).join(", ");
    label.append(words + " ", input);
    place.append(label);
  }
}
// One number, two, or pairs apart by semicolons.
function readField(input, kind) {
  const text = input.value;
  const numbers = (words, count) => {
    const found = words.split(count === 1 ? /\s+/ : /[,\s]+/).filter(Boolean).map(word => Number(count === 1 ? word.replace(",", ".") : word));
    if (found.length !== count || !found.every(Number.isFinite)) {
      const allowed = count === 1 ? "a number" : "two numbers apart by a comma, with decimal points";
      throw new Wrong(`${label(input)}: “${words.trim()}” is not ${allowed}. Nothing was sent.`);
    }
    return found;
  };
  if (kind === 3) return text.split(";").filter(words => words.trim()).map(words => numbers(words, 2));
  return kind === 2 ? numbers(text, 2) : numbers(text, 1)[0];
}
objectForm.shape.addEventListener("change", () => objectFields(null));
objectForm.addEventListener("submit", event => {
  event.preventDefault();
  askWith(() => {
    const shape = objectForm.shape.value, object = { shape };
    for (const [key, , kind] of FIELDS[shape]) object[key] = readField(objectForm.elements[key], kind);
    return { object: { finger: which() ?? 0, object } };
  }, objectForm.querySelector("output"));
});
limitsForm.addEventListener("submit", event => {
  event.preventDefault();
  askWith(() => {
    const limits = {};
    for (const input of limitsForm.querySelectorAll("input")) limits[input.name] = input.name === "drive" ? input.value : number(input);
    limits.on_fault = limitsForm.on_fault.value;
    return { limits: { finger: which() ?? 0, limits } };
  }, limitsForm.querySelector("output"));
});
$("finger").addEventListener("change", showSettings);
function showSettings() {
  const finger = setup && setup.fingers[which() ?? 0];
  if (!finger) return;
  if (finger.object) {
    const { shape, ...values } = finger.object;
    objectForm.shape.value = shape;
    objectFields(values);
  } else {
    objectFields(null);
  }
  for (const [name, value] of Object.entries(finger.limits)) {
    const input = limitsForm.elements[name];
    if (input) input.value = typeof value === "number" ? Number(value.toPrecision(6)) : value;
  }
}

// ---- what the server tells
function takeSetup(told) {
  setup = told;
  $("target").textContent = told.target;
  document.querySelector("footer").hidden = !told.moves;
  root.classList.toggle("watching", !told.moves);
  for (const button of $("settings").querySelectorAll("button")) button.disabled = !told.takes;
  if (cards.length !== told.fingers.length) {
    cards.length = 0;
    $("fingers").replaceChildren();
    told.fingers.forEach((finger, index) => cards.push(card(finger, index)));
    $("finger").replaceChildren(...told.fingers.map((_, index) => new Option(`finger ${index}`, index)));
    $("which").hidden = told.fingers.length < 2;
  }
  cards.forEach((c, index) => { c.setup = told.fingers[index]; c.view = null; });
  showSettings();
  dirty = true;
}
function card(finger, index) {
  const node = $("finger-template").content.firstElementChild.cloneNode(true);
  node.querySelector("h2").textContent = finger.name;
  node.dataset.finger = index;
  $("fingers").append(node);
  const is = {};
  for (const part of node.querySelectorAll("[data-is]")) is[part.dataset.is] = part;
  const [force, angle] = node.querySelectorAll(".chart");
  return { node, is, picture: node.querySelector(".picture"), force, angle, points: [], silent: 0, shape: null, setup: finger, view: null, arrow: 1, pressure: 0.1 };
}
const fixed = (value, digits) => (Math.abs(value) < 0.5 * 10 ** -digits ? 0 : value).toFixed(digits);
function takeFrame(told) {
  frame = told;
  heard = performance.now();
  told.fingers.forEach((f, index) => {
    const c = cards[index];
    if (!c || !f) return;
    if (f.shape) c.shape = f.shape;
    for (const point of f.points) {
      const last = c.points[c.points.length - 1];
      if (last && point[0] < last[0]) c.points.length = 0; // the target has started anew
      c.points.push(point);
    }
    const now = f.time_s;
    while (c.points.length && c.points[0][0] < now - WINDOW - 1) c.points.shift();
    const { is } = c;
    c.node.dataset.sequence = f.sequence;
    is.force.textContent = f.force_n.toFixed(2);
    is.status.textContent = f.status + (f.age ? ` · ${f.age} ticks old` : "");
    is.status.className = "status " + (f.trustworthy ? "good" : "bad");
    c.node.classList.toggle("untrusted", !f.trustworthy);
    is.lost.hidden = f.untrustworthy_percent < 0.05;
    is.lost.textContent = `${f.untrustworthy_percent.toFixed(f.untrustworthy_percent < 9.95 ? 1 : 0)} % of the last second's estimates untrustworthy`;
    is.phase.textContent = f.phase;
    is.angle.textContent = fixed(f.angle_deg, 2);
    is.goal.textContent = fixed(f.goal_deg, 2);
    is.deviation.textContent = f.deviation_n === null ? "?" : fixed(f.deviation_n, 2);
    is.loaded.hidden = !f.rib;
    if (f.rib) is.rib.textContent = f.rib;
    is.between.hidden = !f.interval_n;
    if (f.interval_n) is.interval.textContent = f.interval_n.map(x => fixed(x, 2)).join(" and ");
    is.centre.textContent = f.centre_mm ? f.centre_mm.map(x => fixed(x, 1)).join(", ") : "–";
    is.components.textContent = `${fixed(f.force_xy_n[0], 2)}, ${fixed(f.force_xy_n[1], 2)}`;
    is.torque.textContent = fixed(f.torque_nmm, 0);
    const touching = f.extent_mm > 0 || f.force_n > 0;
    is["gap-name"].textContent = touching ? "contact over" : "distance";
    is.gap.textContent = fixed(touching ? f.extent_mm : f.distance_mm, touching ? 1 : 2);
    is.pressure.textContent = c.shape ? fixed(Math.max(0, ...pressures(c.shape.contacts).map(p => p[2])), 2) : "–";
    is.current.textContent = fixed(f.current_ma, 0);
    is.cost.textContent = f.cost;
  });
  $("resume").hidden = !(setup && setup.demonstration && told.paused);
  const grasp = told.grasp;
  $("grasp").hidden = !grasp;
  if (grasp) {
    $("squeeze").textContent = grasp.trustworthy ? fixed(grasp.squeeze_n, 2) : "–";
    $("sum").textContent = grasp.trustworthy ? grasp.sum_n.map(x => fixed(x, 2)).join(", ") : "–";
    $("balance").textContent = grasp.trustworthy ? fixed(100 * grasp.balance, 0) : "–";
    const free = grasp.free;
    $("free").hidden = !free;
    if (free) $("place").textContent = `${free.status}, ${free.shift_mm.map(x => fixed(x, 2)).join(", ")}`;
    drawMargin(grasp.trustworthy ? grasp.margin : null);
  }
  const rows = told.counts;
  const list = $("counts");
  if (list.children.length !== rows.length) {
    list.replaceChildren(...rows.map(([name]) => {
      const row = document.createElement("div"), dt = document.createElement("dt"), dd = document.createElement("dd");
      dt.textContent = name;
      row.append(dt, dd);
      return row;
    }));
  }
  rows.forEach(([, value], index) => { list.children[index].lastChild.textContent = value; });
  dirty = true;
}
function takeNotice(told) {
  const item = document.createElement("li");
  item.textContent = `${told.time_s.toFixed(3)} s  ${told.words}`;
  if (told.bad) item.className = "bad";
  $("events").prepend(item);
  while ($("events").children.length > 30) $("events").lastChild.remove();
}
// How long nothing has come from a target that is running, ms; 0 while it is not noteworthy: a slow one reports seldom.
function silence() {
  if (!setup || !setup.takes || !frame) return 0;
  const silent = performance.now() - heard + frame.silent_ms;
  const slowest = Math.min(...setup.fingers.map(finger => finger.limits.rate_hz));
  return frame.closed || silent > Math.max(400, 2500 / slowest) ? silent : 0;
}
// What a target told that is silent now: struck out, with its age, and the charts go on without it.
function ageNumbers() {
  const silent = silence();
  cards.forEach(c => {
    if (!silent && !c.silent) return;
    c.silent = silent;
    c.node.classList.toggle("dead", silent > 0);
    dirty = true;
    if (!silent) return;
    c.node.classList.add("untrusted");
    c.is.status.textContent = `silent · ${(silent / 1000).toFixed(1)} s old`;
    c.is.status.className = "status bad";
  });
  $("grasp").classList.toggle("untrusted", silent > 0);
}
function linkState() {
  const chip = $("link");
  const quiet = performance.now() - heard;
  ageNumbers();
  notStopped();
  // A recording takes nothing: it plays.
  let words = setup && !setup.takes ? "playing" : "live", kind = "good";
  if (frame && frame.closed) [words, kind] = [setup && !setup.moves ? "ended" : "the gripper is gone", "bad"];
  else if (events.readyState === EventSource.CLOSED && !heard) [words, kind] = ["not let in: open the address that fre printed", "bad"];
  else if (quiet > 1500) [words, kind] = [heard ? `nothing for ${(quiet / 1000).toFixed(0)} s` : "connecting", "bad"];
  else if (silence()) [words, kind] = [`gripper silent for ${(silence() / 1000).toFixed(1)} s`, "bad"];
  if (chip.textContent !== words) chip.textContent = words;
  chip.className = "chip " + kind;
}

// ---- pictures
function pen(canvas) {
  const ratio = devicePixelRatio || 1, { clientWidth: w, clientHeight: h } = canvas;
  if (canvas.width !== Math.round(w * ratio) || canvas.height !== Math.round(h * ratio)) {
    canvas.width = Math.round(w * ratio);
    canvas.height = Math.round(h * ratio);
  }
  const g = canvas.getContext("2d");
  g.setTransform(ratio, 0, 0, ratio, 0, 0);
  g.clearRect(0, 0, w, h);
  g.lineCap = g.lineJoin = "round";
  g.font = `${w < 500 ? 11 : 12}px system-ui, sans-serif`;
  return { g, w, h };
}
function path(g, points, close) {
  g.beginPath();
  points.forEach((p, i) => i ? g.lineTo(p[0], p[1]) : g.moveTo(p[0], p[1]));
  if (close) g.closePath();
}
function arrow(g, from, to, width) {
  const [dx, dy] = [to[0] - from[0], to[1] - from[1]], length = Math.hypot(dx, dy);
  if (length < 2) return;
  const head = Math.min(4 + 2.2 * width, length), [ux, uy] = [dx / length, dy / length];
  const neck = [to[0] - head * ux, to[1] - head * uy];
  g.lineWidth = width;
  path(g, [from, neck]);
  g.stroke();
  path(g, [to, [neck[0] - 0.45 * head * uy, neck[1] + 0.45 * head * ux], [neck[0] + 0.45 * head * uy, neck[1] - 0.45 * head * ux]], true);
  g.fill();
}
// Contact pressure in N per mm of beam: a sample's force over the length it stands for. [x, y, pressure, nx, ny]
function pressures(contacts) {
  return contacts.map(([x, y, fx, fy], i) => {
    const apart = j => contacts[j] ? Math.hypot(contacts[j][0] - x, contacts[j][1] - y) : null;
    const [before, after] = [apart(i - 1), apart(i + 1)];
    const gaps = [before, after].filter(gap => gap !== null && gap < APART);
    const length = gaps.length ? gaps.reduce((a, b) => a + b) / gaps.length : 1;
    const size = Math.hypot(fx, fy) || 1;
    return [x, y, Math.hypot(fx, fy) / length, fx / size, fy / size];
  });
}
// From where an object was set to where it is: a free one goes and turns, in the gripper's frame.
function freed(c) {
  const free = frame && frame.grasp && frame.grasp.free;
  if (!free || !c.setup.object_centre_mm) return p => p;
  const sense = c.setup.mirrored ? -1 : 1, turn = sense * free.turn_deg * Math.PI / 180;
  const [x, y] = c.setup.object_centre_mm, [dx, dy] = free.shift_mm;
  const [sin, cos] = [Math.sin(turn), Math.cos(turn)];
  return ([px, py]) => [x + sense * dx + cos * (px - x) - sin * (py - y), y + dy + sin * (px - x) + cos * (py - y)];
}
function drawFinger(c, f) {
  const { g, w, h } = pen(c.picture);
  const { design, mirrored } = c.setup;
  if (!design) { g.fillStyle = ink.muted; g.fillText("the target has no finger yet", 12, 24); return; }
  const [mx, my] = design.axis_mm;
  const turn = (angle, rotateOnly) => {
    const [sin, cos] = [Math.sin(angle), Math.cos(angle)];
    return ([x, y]) => rotateOnly ? [cos * x + sin * y, -sin * x + cos * y]
      : [mx + cos * (x - mx) + sin * (y - my), my - sin * (x - mx) + cos * (y - my)];
  };
  // A base that is moved along a line.
  const shifted = ([dx, dy]) => ([x, y]) => [x + dx, y + dy];
  if (!c.view) {
    // What the finger can reach, the same for all frames.
    const all = c.setup.way_mm ? [] : [[mx, my]];
    const way = c.setup.way_mm;
    const ends = way ? way.map(shifted) : [c.setup.limits.open_deg, 0, 14].map(degrees => turn(degrees * Math.PI / 180));
    for (const move of ends) {
      design.front_mm.concat(design.back_mm).forEach(p => all.push(move(p)));
    }
    const xs = all.map(p => p[0]), ys = all.map(p => p[1]);
    c.view = { left: Math.min(...xs) - 8, right: Math.max(...xs) + 18, low: Math.min(...ys) - 6, high: Math.max(...ys) + 7 };
  }
  const v = c.view, scale = Math.min(w / (v.right - v.left), h / (v.high - v.low));
  // A wide picture shows more of the object than of what is behind the finger.
  const side = 0.2 * (w - scale * (v.right - v.left)), top = 0.5 * (h - scale * (v.high - v.low));
  const at = ([x, y]) => {
    const across = side + scale * (x - v.left);
    return [mirrored ? w - across : across, h - top - scale * (y - v.low)];
  };
  g.save();
  if (c.setup.object_contour_mm) {
    path(g, c.setup.object_contour_mm.map(freed(c)).map(at), true);
    g.fillStyle = ink.object;
    g.fill();
    g.strokeStyle = ink.objectedge;
    g.lineWidth = 1.4;
    g.stroke();
  }
  const shape = c.shape;
  const move = c.setup.way_mm ? shifted(shape ? shape.shift_mm : c.setup.way_mm[0])
    : turn(shape ? shape.angle_rad : (f ? f.angle_deg * Math.PI / 180 : 0));
  const line = (points, width, colour, dash) => {
    g.setLineDash(dash || []);
    g.lineWidth = width;
    g.strokeStyle = colour;
    path(g, points.map(p => at(move(p))));
    g.stroke();
    g.setLineDash([]);
  };
  // The arm from the motor's axis, if it is turned, and the base.
  const [front0, back0] = [design.front_mm[0], design.back_mm[0]];
  if (!c.setup.way_mm) line([design.axis_mm, [0.5 * (front0[0] + back0[0]), front0[1] - 2]], 6 * scale, ink.faint);
  line(design.front_mm, 1, ink.ghost, [4, 4]);
  line(design.back_mm, 1, ink.ghost, [4, 4]);
  line([back0, front0].map(([x, y]) => [x, y - 2]), 4 * scale, ink.ghost);
  if (shape) {
    shape.lamellae_mm.forEach(bar => line(bar, design.lamella_mm * scale, ink.lamella));
    line(shape.back_mm, design.back_thickness_mm * scale, ink.back);
    line(shape.front_mm, design.front_thickness_mm * scale, ink.front);
    // Contact pressure: an area from the beam's surface towards the inside of the finger, one for every stretch that touches.
    const found = pressures(shape.contacts), peak = Math.max(0, ...found.map(p => p[2]));
    c.pressure = Math.max(c.pressure * 0.995, peak);
    const reach = 11 / c.pressure;
    const groups = [];
    found.forEach((p, i) => {
      const before = found[i - 1];
      if (before && Math.hypot(p[0] - before[0], p[1] - before[1]) < APART) groups[groups.length - 1].push(p); else groups.push([p]);
    });
    for (const group of groups) {
      const outer = group.map(([x, y]) => [x, y]);
      const inner = group.map(([x, y, p, nx, ny]) => [x - reach * p * nx, y - reach * p * ny]).reverse();
      g.globalAlpha = 0.45;
      if (group.length === 1) {
        line([outer[0], inner[0]], 5, ink.force);
      } else {
        g.fillStyle = ink.force;
        path(g, outer.concat(inner).map(p => at(move(p))), true);
        g.fill();
      }
      g.globalAlpha = 1;
    }
    g.fillStyle = g.strokeStyle = ink.force;
    const largest = Math.max(...shape.contacts.map(p => Math.hypot(p[2], p[3])), 0);
    // Arrows grow with the force up to 18 mm; a larger force changes the scale for all.
    c.arrow = Math.max(c.arrow * 0.995, largest, 0.5);
    g.globalAlpha = 0.75;
    for (const [x, y, fx, fy] of shape.contacts) {
      const size = 12 / c.arrow;
      arrow(g, at(move([x, y])), at(move([x + size * fx, y + size * fy])), 1.2);
    }
    g.globalAlpha = 1;
    const [sx, sy] = shape.contacts.reduce(([a, b], p) => [a + p[2], b + p[3]], [0, 0]), size = Math.hypot(sx, sy);
    if (size > 0) {
      const weight = shape.contacts.map(p => Math.hypot(p[2], p[3])), total = weight.reduce((a, b) => a + b, 0);
      const centre = shape.contacts.reduce(([a, b], p, i) => [a + weight[i] / total * p[0], b + weight[i] / total * p[1]], [0, 0]);
      const length = Math.min(24, 6 + 18 * size / (size + 8));
      const end = at(move([centre[0] + length * sx / size, centre[1] + length * sy / size]));
      arrow(g, at(move(centre)), end, 3);
      g.font = "bold 14px system-ui, sans-serif";
      g.lineWidth = 4;
      g.strokeStyle = ink.card;
      g.textAlign = mirrored ? "right" : "left";
      const words = (f ? f.force_n : size).toFixed(2) + " N", x = Math.min(Math.max(end[0] + (mirrored ? -6 : 6), 60), w - 60);
      g.strokeText(words, x, end[1] - 8);
      g.fillText(words, x, end[1] - 8);
    }
    if (!shape.trustworthy || c.silent) {
      g.font = "bold 14px system-ui, sans-serif";
      g.textAlign = "left";
      g.fillStyle = ink.bad;
      g.fillText(c.silent ? `${(c.silent / 1000).toFixed(1)} s old` : `${shape.status}: an old shape`, 8, 18);
    }
  }
  // A scale of 10 mm.
  g.textAlign = "left";
  g.font = "11px system-ui, sans-serif";
  g.fillStyle = g.strokeStyle = ink.muted;
  g.lineWidth = 2;
  path(g, [[10, h - 8], [10 + 10 * scale, h - 8]]);
  g.stroke();
  g.fillText("10 mm", 10, h - 14);
  g.restore();
  c.picture.setAttribute("aria-label", f ? `The finger at ${fixed(f.angle_deg, 1)} degrees, ${f.force_n.toFixed(2)} newton, ${f.status}` : "The finger");
}
function ticks(low, high, count) {
  const raw = (high - low) / count, power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map(k => k * power).find(s => s >= raw) || power;
  const list = [];
  for (let x = Math.ceil(low / step) * step; x <= high + 1e-9; x += step) list.push([x, Math.max(0, -Math.floor(Math.log10(step) + 1e-9))]);
  return list;
}
// Points: [time, force least, force greatest, force, angle, goal, trustworthy]
function drawChart(canvas, points, silent, title, series, least) {
  const { g, w, h } = pen(canvas), [left, right, top, bottom] = [42, 8, 18, 18];
  const end = points.length ? points[points.length - 1][0] + silent / 1000 : WINDOW, start = end - WINDOW;
  let low = least[0], high = least[1];
  for (const p of points) for (const s of series) { low = Math.min(low, p[s.low]); high = Math.max(high, p[s.high]); }
  high += 0.06 * (high - low);
  if (low < 0) low -= 0.06 * (high - low);
  const x = t => left + (w - left - right) * (t - start) / WINDOW;
  const y = v => h - bottom - (h - top - bottom) * (v - low) / (high - low);
  g.strokeStyle = ink.faint;
  g.fillStyle = ink.muted;
  g.lineWidth = 1;
  g.textAlign = "right";
  g.textBaseline = "middle";
  for (const [value, digits] of ticks(low, high, 4)) {
    path(g, [[left, y(value)], [w - right, y(value)]]);
    g.stroke();
    g.fillText(value.toFixed(digits), left - 5, y(value));
  }
  g.textAlign = "center";
  g.textBaseline = "alphabetic";
  for (let ago = WINDOW; ago >= 0; ago -= 5) {
    g.textAlign = ago ? "center" : "right";
    g.fillText(ago ? `−${ago} s` : "now", x(end - ago), h - 4);
  }
  g.textAlign = "left";
  let at = left;
  for (const s of series) {
    g.fillStyle = s.colour;
    g.fillText(s.name, at, 12);
    at += g.measureText(s.name).width + 14;
  }
  g.save();
  g.beginPath();
  g.rect(left, 0, w - left - right, h);
  g.clip();
  for (const s of series) {
    if (s.low !== s.high) {
      g.globalAlpha = 0.3;
      g.fillStyle = s.colour;
      path(g, points.map(p => [x(p[0]), y(p[s.high])]).concat(points.map(p => [x(p[0]), y(p[s.low])]).reverse()), true);
      g.fill();
      g.globalAlpha = 1;
    }
    g.lineWidth = s.dashed ? 1.2 : 1.8;
    // Stretches that may not be used are grey and dashed.
    let run = [];
    const flush = good => {
      if (run.length > 1) {
        g.strokeStyle = good ? s.colour : ink.ghost;
        g.setLineDash(good && !s.dashed ? [] : [3, 3]);
        path(g, run);
        g.stroke();
      }
    };
    points.forEach((p, i) => {
      if (i && p[0] - points[i - 1][0] > GAP) { flush(s.guarded ? points[i - 1][6] : 1); run = []; }
      else if (i && p[6] !== points[i - 1][6] && s.guarded) { flush(points[i - 1][6]); run = run.slice(-1); }
      run.push([x(p[0]), y(p[s.value])]);
    });
    if (points.length) flush(s.guarded ? points[points.length - 1][6] : 1);
    g.setLineDash([]);
  }
  g.restore();
  canvas.setAttribute("aria-label", title);
}
function drawCard(c, f) {
  drawFinger(c, f);
  drawChart(c.force, c.points, c.silent, "Force over the last 20 seconds", [{ name: "force (N)", low: 1, high: 2, value: 3, colour: ink.force, guarded: true }], [0, 1]);
  drawChart(c.angle, c.points, c.silent, "Motor angle and goal over the last 20 seconds", [
    { name: "motor angle (°)", low: 4, high: 4, value: 4, colour: ink.angle },
    { name: "goal (°)", low: 5, high: 5, value: 5, colour: ink.goal, dashed: true },
  ], [0, 1]);
}
function draw() {
  requestAnimationFrame(draw);
  linkState();
  if (!dirty) return;
  dirty = false;
  cards.forEach((c, index) => drawCard(c, frame && frame.fingers[index]));
}
addEventListener("resize", () => { dirty = true; });

const events = new EventSource("/events" + (token ? "?token=" + encodeURIComponent(token) : ""));
events.addEventListener("setup", event => takeSetup(JSON.parse(event.data)));
events.addEventListener("frame", event => takeFrame(JSON.parse(event.data)));
events.addEventListener("notice", event => takeNotice(JSON.parse(event.data)));
theme();
draw();
