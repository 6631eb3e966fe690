"use strict";
// Selects solvers, sorts tables and shows the tooltips of dots. Without it the page is complete, with the best few solvers highlighted.
const marks = document.querySelectorAll("g[data-label], g[data-dots]");
const bands = document.querySelectorAll("g[data-band]");
const chips = document.querySelectorAll("button[data-label], button[data-family]");
const chosen = new Set();

function show() {
  document.getElementById("rest")?.remove();
  for (const mark of marks) {
    mark.classList.toggle("faint", chosen.size > 0 && !chosen.has(mark.dataset.label || mark.dataset.dots));
  }
  for (const band of bands) band.classList.toggle("gone", !chosen.has(band.dataset.band));
  for (const chip of chips) {
    const own = chip.dataset.label ? [chip.dataset.label] : chip.dataset.family.split(" ");
    chip.setAttribute("aria-pressed", own.every((label) => chosen.has(label)));
  }
}

for (const chip of chips) {
  chip.disabled = false;
  chip.addEventListener("click", () => {
    const own = chip.dataset.label ? [chip.dataset.label] : chip.dataset.family.split(" ");
    const all = own.every((label) => chosen.has(label));
    for (const label of own) all ? chosen.delete(label) : chosen.add(label);
    show();
  });
}

// The key by which a cell is sorted: a number in its unit, or text; missing values are last.
const UNITS = { "µs": 1e-6, ms: 1e-3, s: 1, "%": 1e-2 };
function sortKey(cell) {
  const text = cell ? cell.textContent.trim() : "";
  const found = /^×?(-?[\d.]+(?:e[-+]?\d+)?)(?:\/[\d.]+)?\s*(µs|ms|s|%)?/.exec(text);
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
