
// The reader's own selection of problems: see reports/filter.py for the data.
for (const section of document.querySelectorAll(".filter")) {
  const data = JSON.parse(section.querySelector("script").textContent), choices = section.querySelector(".choices");
  const chooser = (name) => choices.querySelector(`[name=${name}]`);
  const [LABEL, SCENE, FAMILY, PROBLEM, STRATUM, DIMENSION, CONTACTS, TOL, BODIES, FORM, LIMIT, RESIDUAL, SOLVED] = Array(13).keys();
  const SHIFT = 1e-5; // s, as in reports.accuracy
  const sizes = [["1 to 10", 0, 10], ["11 to 100", 10, 100], ["more than 100", 100, Infinity]];
  const there = (column) => new Set(data.cells.map((cell) => cell[column]));
  const fill = (name, options) => {
    for (const [value, text] of options) chooser(name).append(new Option(text, value));
  };
  const dimensions = there(DIMENSION), tolerances = [...there(TOL)].sort((a, b) => a - b);
  fill("dimension", [[2, "in the plane"], [3, "in space"]].filter(([d]) => dimensions.has(d)));
  fill("scene", [["", "all"], ...data.scene.map((name, k) => [k, name])]);
  fill("contacts", [["", "all"], ...sizes.map(([text], k) => [k, text])]);
  fill("tol", tolerances.map((tol) => [tol, tol.toExponential(0)]));
  fill("family", [["", "all"], ...data.family.map((name, k) => [k, name || "no family"])]);
  fill("mine", [["", "none"], ...data.label.map((name, k) => [k, name])]);

  const written = (time) => {
    const [scale, unit] = time < 9.995e-4 ? [1e-6, "µs"] : time < 0.9995 ? [1e-3, "ms"] : [1, "s"];
    return `${Number((time / scale).toPrecision(3))} ${unit}`;
  };
  const median = (pairs) => {
    pairs.sort((a, b) => a[0] - b[0]);
    let sum = 0;
    return (pairs.find(([, weight]) => (sum += weight) > 0.5 + 1e-9) || pairs[pairs.length - 1])[0];
  };

  function ranked() {
    const chosen = Object.fromEntries(["dimension", "scene", "contacts", "tol", "family"].map((name) => [name, chooser(name).value]));
    const column = document.getElementById("rank-by-form")?.checked ? FORM : BODIES;
    const [, above, most] = sizes[chosen.contacts] || ["", -1, Infinity];
    const cells = data.cells.filter((cell) => cell[DIMENSION] === Number(chosen.dimension) && cell[TOL] === Number(chosen.tol)
      && (chosen.scene === "" || cell[SCENE] === Number(chosen.scene)) && cell[CONTACTS] > above && cell[CONTACTS] <= most);
    const strata = new Map();
    for (const cell of cells) strata.set(cell[STRATUM], (strata.get(cell[STRATUM]) || new Set()).add(cell[PROBLEM]));
    const problems = new Set(cells.map((cell) => cell[PROBLEM])).size;
    const weight = (cell) => 1 / strata.size / strata.get(cell[STRATUM]).size;
    const found = [];
    data.label.forEach((label, k) => {
      const own = cells.filter((cell) => cell[LABEL] === k && (chosen.family === "" || cell[FAMILY] === Number(chosen.family)));
      if (!own.length) return;
      const solved = own.filter((cell) => cell[SOLVED]).length, whole = new Set(own.map((cell) => cell[PROBLEM])).size === problems;
      const logs = own.map((cell) => weight(cell) * Math.log((cell[SOLVED] ? cell[column] : cell[LIMIT]) + SHIFT));
      const mean = whole && own.length === problems ? Math.exp(logs.reduce((a, b) => a + b)) - SHIFT : NaN;
      const residual = median(own.map((cell) => [cell[RESIDUAL] ?? Infinity, weight(cell)]));
      found.push({ k, label, solved, of: own.length, mean, residual });
    });
    return found.sort((a, b) => (Number.isNaN(a.mean) ? 1 : 0) - (Number.isNaN(b.mean) ? 1 : 0) || a.mean - b.mean);
  }

  const SVG = "http://www.w3.org/2000/svg";
  function draw(svg, rows, mine) {
    const put = (name, attributes, text) => {
      const made = document.createElementNS(SVG, name);
      for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
      if (text !== undefined) made.textContent = text;
      svg.append(made);
      return made;
    };
    svg.replaceChildren();
    const points = rows.filter((row) => row.mean > 0).map((row) => ({ ...row, x: Math.log10(row.mean), y: Math.log10(Math.min(Math.max(row.residual, 1e-17), 10)) }));
    if (!points.length) return;
    const span = (values) => [Math.floor(Math.min(...values) - 0.15), Math.ceil(Math.max(...values) + 0.15)];
    const [left, right] = span(points.map(({ x }) => x)), [low, high] = span(points.map(({ y }) => y));
    const X = (x) => 66 + 420 * (x - left) / (right - left), Y = (y) => 285 - 270 * (y - low) / (high - low);
    const every = Math.ceil((high - low) / 6);
    for (let x = left; x <= right; x++) {
      put("line", { x1: X(x), x2: X(x), y1: 15, y2: 285, stroke: "currentColor", "stroke-opacity": 0.15 });
      put("text", { x: X(x), y: 310, "text-anchor": "middle", "font-size": 12, fill: "currentColor" }, written(10 ** x));
    }
    for (let y = low; y <= high; y += every) {
      put("line", { x1: 66, x2: 486, y1: Y(y), y2: Y(y), stroke: "currentColor", "stroke-opacity": 0.15 });
      put("text", { x: 58, y: Y(y) + 4, "text-anchor": "end", "font-size": 12, fill: "currentColor" }, `1e${y}`);
    }
    put("text", { x: 276, y: 334, "text-anchor": "middle", "font-size": 12, fill: "currentColor" }, "mean time; upwards the median verified residual");
    for (const row of points) {
      const own = row.k === mine;
      const dot = put("circle", { cx: X(row.x), cy: Y(row.y), r: own ? 8 : 5, fill: data.colours[row.k] || "currentColor", "fill-opacity": mine === undefined || own ? 1 : 0.35 });
      dot.append(document.createElementNS(SVG, "title"));
      dot.firstChild.textContent = `${row.label}: ${written(row.mean)}, ${row.residual.toExponential(0)}`;
      if (own) put("text", { x: X(row.x), y: Y(row.y) - 12, "text-anchor": row.x > (left + right) / 2 ? "end" : "start", "font-size": 13, "font-weight": 600, fill: "currentColor" }, row.label);
    }
  }

  function select() {
    const mine = chooser("mine").value === "" ? undefined : Number(chooser("mine").value), rows = ranked();
    section.querySelector("tbody").replaceChildren(...rows.map((row) => {
      const line = document.createElement("tr");
      const dot = Object.assign(document.createElement("i"), { className: "dot" });
      dot.style.background = data.colours[row.k];
      line.append(...[row.label, `${row.solved}/${row.of}`, Number.isNaN(row.mean) ? "–" : written(row.mean), Number.isFinite(row.residual) ? row.residual.toExponential(0) : "–"]
        .map((text) => Object.assign(document.createElement("td"), { textContent: text })));
      line.firstChild.prepend(dot);
      line.classList.toggle("mine", row.k === mine);
      return line;
    }));
    draw(section.querySelector("svg"), rows, mine);
  }
  section.hidden = false;
  choices.addEventListener("input", select);
  document.querySelector(".switch")?.addEventListener("input", select);
  select();
}
