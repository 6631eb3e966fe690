// Selects solvers, sorts tables, and shows the tooltips of dots. Without it the page is complete, with the best few solvers highlighted.
const marks = document.querySelectorAll("g[data-label], g[data-dots]");
const chips = document.querySelectorAll("button[data-label]");
const chosen = new Set();

function show() {
  document.getElementById("rest")?.remove();
  for (const mark of marks) {
    mark.classList.toggle("faint", chosen.size > 0 && !chosen.has(mark.dataset.label || mark.dataset.dots));
  }
  for (const chip of chips) {
    chip.setAttribute("aria-pressed", chosen.has(chip.dataset.label));
  }
}

for (const chip of chips) {
  chip.disabled = false;
  chip.addEventListener("click", () => {
    const { label } = chip.dataset;
    if (!chosen.delete(label)) chosen.add(label);
    show();
  });
}

// The key by which a cell is sorted: a number in its unit, or text; missing values are last.
const UNITS = { "µs": 1e-6, ms: 1e-3, s: 1, "%": 1e-2 };
function sortKey(cell) {
  const text = cell ? cell.textContent.trim() : "";
  const found = /^[×<]?(-?[\d.]+(?:e[-+]?\d+)?)(?:\/[\d.]+)?\s*(µs|ms|s|%)?/.exec(text);
  if (text === "–" || text === "") return Infinity;
  return found ? Number(found[1]) * (UNITS[found[2]] || 1) : text;
}

for (const table of document.querySelectorAll("table.sorts")) {
  const heads = [...table.rows].filter((row) => row.querySelector("th"));
  const last = heads[heads.length - 1];
  const body = [...table.rows].filter((row) => !row.querySelector("th"));
  [...last.cells].forEach((head, column) => {
    head.tabIndex = 0;
    const sort = () => {
      const down = head.getAttribute("aria-sort") === "ascending";
      for (const other of last.cells) other.removeAttribute("aria-sort");
      head.setAttribute("aria-sort", down ? "descending" : "ascending");
      const keyed = body.map((row, at) => [sortKey(row.cells[column]), at, row]);
      keyed.sort(([a, i], [b, j]) => {
        if (typeof a !== typeof b) return typeof a === "number" ? -1 : 1;
        const order = a < b ? -1 : a > b ? 1 : i - j;
        return down && a !== Infinity && b !== Infinity ? -order : order;
      });
      for (const [, , row] of keyed) row.parentNode.append(row);
    };
    head.addEventListener("click", sort);
    head.addEventListener("keydown", (event) => {
      if (event.key === "Enter" || event.key === " ") {
        event.preventDefault();
        sort();
      }
    });
  });
}

// The dots of a group are in the order of its list of tooltips.
const note = document.getElementById("note");
for (const list of document.querySelectorAll("script[type='application/json']")) {
  const dots = JSON.parse(list.textContent);
  for (const group of list.parentNode.querySelectorAll("g[data-dots]")) {
    const texts = dots[group.dataset.dots] || [];
    [...group.querySelectorAll("use")].forEach((dot, at) => {
      if (texts[at] === undefined) return;
      const showNote = (event) => {
        note.textContent = texts[at];
        note.hidden = false;
        note.style.left = `${Math.max(0, Math.min(event.pageX + 12, window.scrollX + document.documentElement.clientWidth - note.offsetWidth - 8))}px`;
        note.style.top = `${event.pageY + 14}px`;
      };
      dot.addEventListener("pointerenter", showNote);
      dot.addEventListener("pointerleave", () => { note.hidden = true; });
    });
  }
}

// Panels of charts: a button enlarges one to the width of the page.
for (const title of document.querySelectorAll(".panels:not(.whole) > figure > h3")) {
  const button = Object.assign(document.createElement("button"), { className: "enlarge", title: "enlarge", textContent: "⤢" });
  button.addEventListener("click", () => title.parentNode.classList.toggle("large"));
  title.append(button);
}

// Maps: a button enlarges a panel; a click on a tile tells its problem and the commands that solve and show it. The
// transform of the group of tiles gives the place of the first grid point and counts in grid lines.
const shown = (value) => (typeof value === "number" ? String(Number(value.toPrecision(6))) : String(value));
for (const data of document.querySelectorAll("script.facts")) {
  const facts = JSON.parse(data.textContent), told = data.previousElementSibling;
  for (const map of data.parentNode.querySelectorAll(".map")) {
    const svg = map.querySelector("svg"), field = svg.querySelector("g[transform]"), button = map.querySelector(".enlarge");
    button.hidden = false;
    button.addEventListener("click", () => map.classList.toggle("large"));
    svg.addEventListener("click", (event) => {
      const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(field.getScreenCTM().inverse());
      const pick = (axis, line) => {
        const k = Math.round(2 * line);
        return k < 0 || k >= axis.values.length ? undefined : k - (event.target.closest("path, rect")?.querySelector("title") ? 0 : k % 2);
      };
      const i = pick(facts.x, at.x), j = pick(facts.y, at.y);
      if (i === undefined || j === undefined) return;
      const x = facts.x.values[i], y = facts.y.values[j];
      const parameters = { ...facts.parameters, [facts.x.parameter]: x, [facts.y.parameter]: y };
      const scene = `${facts.scene}[${Object.entries(parameters).map(([name, value]) => `${name}=${shown(value)}`).join(",")}]`;
      const title = event.target.querySelector?.("title")?.textContent || "";
      const [, what, command] = /^(.*) · (frictionbench rerun .*)$/s.exec(title) || [];
      const lines = [svg.querySelector("text").textContent, what || title || `${facts.x.parameter} ${shown(x)}, ${facts.y.parameter} ${shown(y)}`];
      if (command) lines.push(command);
      lines.push(`frictionbench solve '${scene}'`, `frictionbench show '${scene}'${facts.scheme === "anitescu_potra" ? "" : ` --scheme ${facts.scheme}`}`);
      told.textContent = lines.join("\n");
      told.hidden = false;
    });
  }
}
