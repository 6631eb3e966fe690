"use strict";
// Choosing solvers, sorting tables and telling what a dot is. The page is whole without it: then the best few stand out.
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

// What a cell is worth in a sorted column: a number with its unit, nothing last, text as text.
const UNITS = { "µs": 1e-6, ms: 1e-3, s: 1, "%": 1e-2 };
function worth(cell) {
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
      const keyed = body.map((row, at) => [worth(row.cells[column]), at, row]);
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

// Dots stand in the drawing in the order of the panel's list of what they are.
const note = document.getElementById("note");
for (const list of document.querySelectorAll("script[type='application/json']")) {
  const dots = JSON.parse(list.textContent);
  for (const group of list.parentNode.querySelectorAll("g[data-dots]")) {
    const told = dots[group.dataset.dots] || [];
    [...group.querySelectorAll("use")].forEach((dot, at) => {
      if (told[at] === undefined) return;
      const tell = (event) => {
        note.textContent = told[at];
        note.hidden = false;
        note.style.left = `${Math.max(0, Math.min(event.pageX + 12, window.scrollX + document.documentElement.clientWidth - note.offsetWidth - 8))}px`;
        note.style.top = `${event.pageY + 14}px`;
      };
      dot.addEventListener("pointerenter", tell);
      dot.addEventListener("pointerleave", () => { note.hidden = true; });
    });
  }
}
