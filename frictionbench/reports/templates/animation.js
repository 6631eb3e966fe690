"use strict";
const page = document.documentElement;
addEventListener("error", (event) => { page.dataset.error = event.message; });

const element = (id) => document.getElementById(id);
const motion = JSON.parse(element("motion").textContent);
const frames = motion.times.length, last = frames - 1;
const stage = element("stage"), chart = element("chart");
const change = motion.energy.map((energy) => energy - motion.energy[0]);
const hinged = motion.pins.length > 0;
const curves = { normal: motion.normal, friction: motion.friction, ...(hinged && { joints: motion.joints }), defect: motion.defect, ink: change };
const largestSize = (values) => values.reduce((a, value) => Math.max(a, Math.abs(value)), 0);
const energyScale = Math.max(largestSize(change), largestSize(motion.kinetic), 1e-3 * largestSize(motion.energy)) || 1;
const d = motion.space ? 3 : 2, stride = 3 * d;  // of a contact: its point, its normal and its impulse
const force = (contacts, k) => Math.hypot(...contacts.slice(k + 2 * d, k + stride)) / motion.step;

// The typical force, the median over the frames of the largest one, has an arrow of ARROW times the size of the view. Arrows are
// truncated at LONGEST times that length.
const ARROW = 0.2, LONGEST = 2.0;
const largest = motion.contacts.map((contacts) => {
  let found = 0;
  for (let k = 0; k < contacts.length; k += stride) found = Math.max(found, force(contacts, k));
  return found;
});
const positive = largest.filter((value) => value > 1e-9 * largestSize(largest)).sort((a, b) => a - b);
const typical = positive.length ? positive[positive.length >> 1] : 1;

let frame = 0, playing = false, speed = 1, clock = 0, previous = 0, request = 0, colour = {};

function number(value, negligible = 1e-300) {
  if (value === null || value === undefined) return "–";
  const size = Math.abs(value);
  if (size < negligible) return "0";
  const text = size >= 1e5 || size < 1e-3 ? value.toExponential(1) : value.toPrecision(size < 1 ? 3 : 4);
  return text.replaceAll("-", "−").replace("+", "");
}

function fit(canvas, height) {
  const ratio = devicePixelRatio || 1, width = canvas.clientWidth;
  if (height) canvas.style.height = height + "px";
  const pixels = [Math.round(width * ratio), Math.round(canvas.clientHeight * ratio)];
  if (canvas.width !== pixels[0] || canvas.height !== pixels[1]) [canvas.width, canvas.height] = pixels;
  const pen = canvas.getContext("2d");
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, canvas.clientHeight);
  pen.lineJoin = pen.lineCap = "round";
  return [pen, width, canvas.clientHeight];
}

function drawStage() {
  const [left, bottom, right, top] = motion.view;
  const wanted = stage.clientWidth * (top - bottom) / (right - left);
  const [pen, width, height] = fit(stage, Math.round(Math.min(Math.max(wanted, 260), 0.68 * innerHeight)));
  const scale = Math.min(width / (right - left), height / (top - bottom));
  const X = (x) => width / 2 + scale * (x - (left + right) / 2), Y = (y) => height / 2 - scale * (y - (bottom + top) / 2);
  const body = scale * motion.size, size = Math.min(Math.max(0.35 * body, 14), 44);
  const reach = Math.max(Math.min(ARROW * Math.min(width, height), 0.9 * body), 40);
  const forces = motion.space ? drawContactsInSpace : drawContacts;
  if (motion.space) drawSpace(pen, X, Y, scale); else drawPlane(pen, X, Y, scale, width, height);

  const trail = playing ? Math.max(1, Math.round(0.2 * speed * frames / (motion.times[last] || 1))) : 0;
  for (let k = Math.max(0, frame - trail); k < frame; k++) {  // an impact lasts one step: its arrows fade over the following frames
    if (largest[k] > LONGEST * typical || largest[frame] === 0) {
      pen.globalAlpha = 0.7 * (1 - (frame - k) / (trail + 1));
      forces(pen, motion.contacts[k], X, Y, reach, 0);
    }
  }
  pen.globalAlpha = 1;
  forces(pen, motion.contacts[frame], X, Y, reach, element("cones").checked ? size : 0);
  drawScales(pen, scale, reach, width, height);
}

function drawPlane(pen, X, Y, scale, width, height) {
  const pose = motion.poses[frame];
  const place = (body, a, b) => {
    if (body < 0) return [X(a), Y(b)];
    const [x, y, angle] = pose.slice(3 * body, 3 * body + 3), cos = Math.cos(angle), sin = Math.sin(angle);
    return [X(x + cos * a - sin * b), Y(y + sin * a + cos * b)];
  };
  for (const outline of motion.outlines) if (outline.body < 0) drawOutline(pen, outline, place, scale, width, height);
  for (const outline of motion.outlines) if (outline.body >= 0) drawOutline(pen, outline, place, scale, width, height);
  for (const [body, a, b] of motion.pins) dot(pen, ...place(body, a, b), 3.5, colour.paper, colour.edge);
}

// In space: an orthographic picture, which a drag turns. The axes of the picture are right, up and towards the viewer.
let azimuth = -0.5, elevation = 0.35;
const dot3 = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const sum = (a, s, b) => a.map((value, k) => value + s * b[k]);  // a + s b
function camera() {
  const [ca, sa, ce, se] = [Math.cos(azimuth), Math.sin(azimuth), Math.cos(elevation), Math.sin(elevation)];
  return [[ca, sa, 0], [-sa * se, ca * se, ce], [sa * ce, -ca * ce, se]];
}

function turned([w, x, y, z], a) {  // the vector a, turned by a unit quaternion
  const t = cross([x, y, z], a).map((value) => 2 * value);
  return sum(sum(a, w, t), 1, cross([x, y, z], t));
}

function drawSpace(pen, X, Y, scale) {
  const [right, up, near] = camera();
  const seen = (point) => { const p = sum(point, -1, motion.centre); return [X(dot3(p, right)), Y(dot3(p, up))]; };
  const area = (points, fill, edge) => {
    pen.beginPath();
    for (const point of points) pen.lineTo(...seen(point));
    pen.closePath();
    pen.fillStyle = fill;
    pen.strokeStyle = edge;
    pen.lineWidth = 1.5;
    pen.fill();
    pen.stroke();
  };
  const far = 1.2 * motion.view[2];
  for (const { corners, endless } of motion.outlines) {
    if (!endless) continue;
    const normal = corners.slice(3), foot = sum(motion.centre, dot3(normal, corners.slice(0, 3)) - dot3(normal, motion.centre), normal);
    const side = cross(normal, Math.abs(normal[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0]), length = Math.hypot(...side);
    const u = side.map((value) => far * value / length), v = cross(normal, u);
    pen.globalAlpha = 0.6;
    area([[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([a, b]) => sum(sum(foot, a, u), b, v)), colour.ground, colour.line);
    pen.globalAlpha = 1;
  }
  const pose = (body) => motion.poses[frame].slice(7 * body, 7 * body + 7);
  const moving = motion.outlines.filter((outline) => outline.body >= 0);
  const depth = (outline) => dot3(pose(outline.body).slice(0, 3), near);
  for (const { body, corners, radius } of [...moving].sort((a, b) => depth(a) - depth(b))) {
    const place = pose(body), centre = place.slice(0, 3), turn = place.slice(3);
    const axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((axis) => turned(turn, axis));
    if (radius > 0) {
      dot(pen, ...seen(centre), scale * radius, colour.body, colour.edge);
      pen.lineWidth = 1;
      for (let k = 0; k < 3; k++) {  // three great circles, where they are in front
        const [u, v] = [axes[(k + 1) % 3], axes[(k + 2) % 3]];
        pen.beginPath();
        for (let i = 0, drawn = false; i <= 60; i++) {
          const a = i * Math.PI / 30, arm = sum(u.map((value) => value * Math.cos(a)), Math.sin(a), v), front = dot3(arm, near) >= 0;
          if (front) pen[drawn ? "lineTo" : "moveTo"](...seen(sum(centre, radius, arm)));
          drawn = front;
        }
        pen.stroke();
      }
      continue;
    }
    const corner = (n) => sum(centre, 1, turned(turn, corners.slice(3 * n, 3 * n + 3)));
    for (let axis = 0; axis < 3; axis++) {
      for (const outer of [0, 1]) {
        if ((2 * outer - 1) * dot3(axes[axis], near) <= 0) continue;
        const bit = [4, 2, 1][axis], [p, q] = [4, 2, 1].filter((value) => value !== bit);
        area([0, p, p + q, q].map((n) => corner(n + outer * bit)), colour.body, colour.edge);
      }
    }
  }
}

function drawContactsInSpace(pen, contacts, X, Y, reach, cone) {
  const [right, up] = camera(), opening = Math.atan(motion.mu);
  const at = (point) => { const p = sum(point, -1, motion.centre); return [X(dot3(p, right)), Y(dot3(p, up))]; };
  for (let k = 0; k < contacts.length; k += stride) {
    const [point, n, impulse] = [0, 3, 6].map((from) => contacts.slice(k + from, k + from + 3));
    const size = force(contacts, k), foot = at(point);
    if (size <= 1e-4 * typical) { dot(pen, ...foot, 2.5, colour.soft); continue; }
    const normal = dot3(n, impulse), tangential = Math.hypot(...sum(impulse, -normal, n));
    const ink = tangential >= 0.9999 * motion.mu * normal ? colour.slide : colour.stick;
    if (cone) {
      const side = cross(n, Math.abs(n[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0]), u = side.map((value) => value / Math.hypot(...side)), v = cross(n, u);
      const alpha = pen.globalAlpha;
      pen.fillStyle = pen.strokeStyle = ink;
      pen.lineWidth = 0.8;
      pen.beginPath();
      for (let i = 0; i < 24; i++) {
        const a = i * Math.PI / 12, s = Math.sin(opening);
        const [e, f] = sum(sum(n.map((value) => value * Math.cos(opening)), s * Math.cos(a), u), s * Math.sin(a), v).reduce(
          ([x, y], value, axis) => [x + value * right[axis], y + value * up[axis]], [0, 0]);
        pen.lineTo(foot[0] + cone * e, foot[1] - cone * f);
        if (i % 6 === 0) { pen.moveTo(...foot); pen.lineTo(foot[0] + cone * e, foot[1] - cone * f); }
      }
      pen.globalAlpha = 0.6 * alpha;
      pen.stroke();
      pen.globalAlpha = alpha;
    }
    if (element("forces").checked) {
      const [fx, fy] = [dot3(impulse, right), dot3(impulse, up)], shown = Math.hypot(fx, fy), whole = Math.hypot(...impulse);
      const length = reach * Math.min(size / typical, LONGEST) * shown / whole;
      if (length > 2) arrow(pen, ...foot, fx / shown, -fy / shown, length, ink, size > LONGEST * typical);
    }
    dot(pen, ...foot, 3, ink);
  }
}

function drawOutline(pen, outline, place, scale, width, height) {
  const { body, corners, radius, endless } = outline, far = 4 * (width + height);
  const points = [];
  for (let k = 0; k < corners.length; k += 2) points.push(place(body, corners[k], corners[k + 1]));
  pen.fillStyle = body < 0 ? colour.ground : colour.body;
  pen.strokeStyle = body < 0 ? colour.soft : colour.edge;
  pen.lineWidth = 1.5;
  pen.beginPath();
  if (endless && radius === 0) {  // a half plane lies left of its line: right of it on a canvas, whose y points down
    const [[x, y], [u, v]] = points, length = Math.hypot(u - x, v - y), c = (u - x) / length, s = (v - y) / length;
    const along = (t, depth) => [x + c * t + s * depth, y + s * t - c * depth];
    for (const corner of [along(-far, 0), along(far, 0), along(far, far), along(-far, far)]) pen.lineTo(...corner);
    pen.closePath();
  } else if (points.length === 1) {
    const size = Math.max(scale * Math.abs(radius), 4);
    if (endless) pen.rect(-9, -9, width + 18, height + 18);
    pen.moveTo(points[0][0] + size, points[0][1]);
    pen.arc(...points[0], size, 0, 2 * Math.PI);
    if (body >= 0) { pen.moveTo(...points[0]); pen.lineTo(...(size > 4 ? place(body, corners[0] + radius, corners[1]) : points[0])); }
  } else {
    for (const point of points) pen.lineTo(...point);
    if (points.length > 2) pen.closePath(); else pen.lineWidth = 5;
  }
  if (points.length !== 2 || endless) pen.fill("evenodd");
  pen.stroke();
}

function dot(pen, x, y, radius, fill, line) {
  pen.beginPath();
  pen.arc(x, y, radius, 0, 2 * Math.PI);
  pen.fillStyle = fill;
  pen.fill();
  if (line) { pen.strokeStyle = line; pen.lineWidth = 1.5; pen.stroke(); }
}

function drawContacts(pen, contacts, X, Y, reach, cone) {
  const opening = Math.atan(motion.mu);
  for (let k = 0; k < contacts.length; k += stride) {
    const [x, y, nx, ny, normal, tangential] = contacts.slice(k, k + 6), at = [X(x), Y(y)];
    const size = force(contacts, k), drawn = size > 1e-4 * typical;
    if (!drawn) { dot(pen, ...at, 2.5, colour.soft); continue; }
    const ink = Math.abs(tangential) >= 0.9999 * motion.mu * normal ? colour.slide : colour.stick;
    if (cone) {
      const axis = Math.atan2(-ny, nx), alpha = pen.globalAlpha;
      pen.beginPath();
      pen.moveTo(...at);
      pen.arc(...at, cone, axis - opening, axis + opening);
      pen.closePath();
      pen.globalAlpha = 0.22 * alpha;
      pen.fillStyle = ink;
      pen.fill();
      pen.globalAlpha = 0.8 * alpha;
      pen.strokeStyle = ink;
      pen.lineWidth = 0.8;
      pen.stroke();
      pen.globalAlpha = alpha;
    }
    if (element("forces").checked) {
      const fx = normal * nx + tangential * ny, fy = normal * ny - tangential * nx, total = Math.hypot(fx, fy);
      const length = reach * Math.min(size / typical, LONGEST);
      arrow(pen, ...at, fx / total, -fy / total, length, ink, size > LONGEST * typical);
    }
    dot(pen, ...at, 3, ink);
  }
}

function arrow(pen, x, y, c, s, length, ink, truncated) {
  const head = Math.min(9, 0.6 * length + 2);
  pen.strokeStyle = pen.fillStyle = ink;
  pen.lineWidth = 2;
  pen.beginPath();
  pen.moveTo(x, y);
  pen.lineTo(x + c * (length - head / 2), y + s * (length - head / 2));
  pen.stroke();
  for (const tip of truncated ? [length, length - 0.8 * head] : [length]) {
    pen.beginPath();
    pen.moveTo(x + c * tip, y + s * tip);
    for (const side of [-0.45, 0.45]) pen.lineTo(x + c * (tip - head) - side * s * head, y + s * (tip - head) + side * c * head);
    pen.closePath();
    pen.fill();
  }
}

function drawScales(pen, scale, reach, width, height) {
  const round = (value) => {  // down to 1, 2 or 5 times a power of ten
    const power = 10 ** Math.floor(Math.log10(value));
    return power * (value >= 5 * power ? 5 : value >= 2 * power ? 2 : 1);
  };
  const metres = round(90 / scale), newtons = round(90 * typical / reach);
  const bars = [[scale * metres, tick(metres) + " m", colour.ink]];
  if (positive.length) bars.push([reach * newtons / typical, tick(newtons) + " N", colour.stick]);
  pen.font = "12px system-ui, sans-serif";
  pen.textAlign = "right";
  bars.forEach(([length, text, ink], row) => {
    const y = 18 + 20 * row;
    pen.fillStyle = pen.strokeStyle = ink;
    pen.lineWidth = 2;
    pen.fillText(text, width - 22 - length, y + 4);
    if (row) arrow(pen, width - 14 - length, y, 1, 0, length, ink, false);
    else { pen.beginPath(); pen.moveTo(width - 14 - length, y - 4); pen.lineTo(width - 14 - length, y); pen.lineTo(width - 14, y); pen.lineTo(width - 14, y - 4); pen.stroke(); }
  });
}

function drawChart() {
  const [pen, width, height] = fit(chart), [west, east, north, south] = [58, 18, 24, 34];
  const all = Object.values(curves).flat(), end = motion.times[last] || 1;
  let [low, high] = all.reduce(([a, b], value) => [Math.min(a, value), Math.max(b, value)], [0, 0]);
  const margin = Math.max(0.05 * (high - low), 0.01 * energyScale);
  [low, high] = [low - margin, high + margin];
  const X = (t) => west + (width - west - east) * t / end, Y = (e) => north + (height - north - south) * (high - e) / (high - low);
  pen.font = "12px system-ui, sans-serif";
  pen.lineWidth = 1;
  const ticks = (a, b, count) => {
    const raw = (b - a) / count, power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].map((m) => m * power).find((value) => value >= raw);
    const found = [];
    for (let i = Math.ceil(a / step - 1e-9); i * step <= b + 1e-9 * step; i++) found.push(i * step);
    return found;
  };
  pen.strokeStyle = colour.line;
  pen.fillStyle = colour.soft;
  pen.textAlign = "right";
  for (const e of ticks(low, high, 5)) { line(pen, west, Y(e), width - east, Y(e)); pen.fillText(tick(e), west - 6, Y(e) + 4); }
  pen.textAlign = "center";
  for (const t of ticks(0, end, 5)) { line(pen, X(t), north, X(t), height - south); pen.fillText(tick(t), X(t), height - south + 16); }
  pen.textAlign = "left";
  pen.fillText("change of energy, J", 8, 15);
  pen.textAlign = "right";
  pen.fillText("time, s", width - east, height - 2);
  for (const [name, curve] of Object.entries(curves)) {
    pen.strokeStyle = colour[name];
    pen.lineWidth = name === "ink" ? 2.4 : 1.6;
    pen.setLineDash(name === "defect" ? [5, 4] : []);
    pen.beginPath();
    curve.forEach((e, k) => pen.lineTo(X(motion.times[k]), Y(e)));
    pen.stroke();
  }
  pen.setLineDash([]);
  pen.strokeStyle = colour.soft;
  pen.lineWidth = 1;
  line(pen, X(motion.times[frame]), north, X(motion.times[frame]), height - south);
  for (const [name, curve] of Object.entries(curves)) dot(pen, X(motion.times[frame]), Y(curve[frame]), name === "ink" ? 4 : 3, colour[name]);
}

function tick(value) {
  const near = Number(value.toPrecision(6));
  return (near && Math.abs(near) < 1e-3 ? near.toExponential() : String(near)).replaceAll("-", "−");
}
const joules = (value) => number(value, 1e-9 * energyScale) + " J";  // smaller values are rounding errors

function line(pen, x, y, u, v) {
  pen.beginPath();
  pen.moveTo(x, y);
  pen.lineTo(u, v);
  pen.stroke();
}

function draw() {
  const style = getComputedStyle(page);
  for (const name of ["ink", "soft", "paper", "line", "ground", "body", "edge", "stick", "slide", "normal", "friction", "joints", "defect"]) {
    colour[name] = style.getPropertyValue("--" + name).trim();
  }
  drawStage();
  drawChart();
  element("play").textContent = playing ? "Pause" : "Play";
  element("frame").value = frame;
  element("time").textContent = `${motion.times[frame].toFixed(decimals)} s of ${motion.times[last].toFixed(decimals)} s`;
  for (const name of ["kinetic", "energy", "friction", "normal", "defect", ...(hinged ? ["joints"] : [])]) element(name).textContent = joules(motion[name][frame]);
  element("change").textContent = joules(change[frame]);
  element("residual").textContent = frame === last ? "–" : number(motion.residual[frame]);
  element("largest").textContent = frame === last ? "–" : number(largest[frame]) + " N";
  page.dataset.frame = frame;
}

function show(wanted) {  // stops the animation at this frame
  playing = false;
  cancelAnimationFrame(request);
  frame = Math.min(Math.max(Math.round(wanted), 0), last);
  clock = motion.times[frame];
  draw();
}

function play() {
  if (frame === last) show(0);
  playing = last > 0;
  previous = performance.now();
  request = requestAnimationFrame(advance);
}

function advance(now) {
  clock += speed * Math.max(0, now - previous) / 1000;
  previous = now;
  while (frame < last && motion.times[frame + 1] <= clock) frame++;
  if (frame === last) return show(last);
  draw();
  request = requestAnimationFrame(advance);
}

// The initial speed: real time, or the fastest slow motion that lasts two seconds or more.
const decimals = Math.max(2, Math.ceil(-Math.log10((motion.times[last] || 1) / Math.max(last, 1))));
const speeds = [1, 1 / 2, 1 / 5, 1 / 10, 1 / 20, 1 / 50, 1 / 100, 1 / 200, 1 / 500, 1 / 1000];
speed = speeds.find((value) => motion.times[last] / value >= 2) || speeds[speeds.length - 1];
for (const value of speeds) {
  const option = new Option(value === 1 ? "real time" : `1/${Math.round(1 / value)} speed`, value, false, value === speed);
  element("speed").add(option);
}
element("speed").addEventListener("change", (event) => { speed = Number(event.target.value); });
element("frame").max = last;
element("frame").addEventListener("input", (event) => show(Number(event.target.value)));
const toggle = () => (playing ? show(frame) : play());
element("play").addEventListener("click", toggle);
for (const id of ["cones", "forces"]) element(id).addEventListener("change", draw);
addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey || event.target.tagName === "SELECT") return;
  const count = event.shiftKey ? 10 : 1;
  const keys = { " ": toggle, ArrowLeft: () => show(frame - count), ArrowRight: () => show(frame + count), Home: () => show(0), End: () => show(last) };
  if (keys[event.key]) { event.preventDefault(); keys[event.key](); }
});
if (motion.space) {
  stage.style.cursor = "grab";
  stage.style.touchAction = "none";
  stage.addEventListener("pointermove", (event) => {
    if (!event.buttons) return;
    azimuth -= 0.01 * event.movementX;
    elevation = Math.min(Math.max(elevation + 0.01 * event.movementY, -1.5), 1.5);
    draw();
  });
}
addEventListener("hashchange", fromHash);
addEventListener("resize", draw);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);

function fromHash() {
  const match = /^#frame=(\d+)$/.exec(location.hash);
  show(match ? Number(match[1]) : 0);
}

fromHash();
page.dataset.status = "ready";
