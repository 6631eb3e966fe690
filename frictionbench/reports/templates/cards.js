"use strict";
// Of each cell the words above its column: where there is no room for columns, rows are shown as cards (page.css). Words above
// several columns are of the first of them, which begins a line. Heads of a table that is printed on several pages are repeated.
for (const table of document.querySelectorAll(".wide > table")) {
  const heads = [], top = table.createTHead();
  for (const row of table.rows) {
    if (!row.querySelector("th")) continue;
    if (row.rowIndex === top.rows.length) top.append(row);
    let column = 0;
    for (const head of row.cells) {
      for (let k = 0; k < head.colSpan; k++, column++) heads[column] = [heads[column], k === 0 && head.textContent.trim().replaceAll("_", "_\u200b").replaceAll("e-", "e-\u2060")].filter(Boolean).join(", ");
    }
  }
  if (heads.length > 3) table.classList.add("several");
  if (heads.length > (table.querySelector(".text") ? 10 : 16)) table.classList.add("many");
  for (const row of table.rows) {
    let column = 0;
    for (const cell of row.cells) {
      cell.dataset.head = heads[column] || "";
      cell.classList.toggle("blank", column > 0 && /^–?$/.test(cell.textContent.trim()));
      column += cell.colSpan;
    }
  }
}

// In print every folded part is open, but for the raw details: each scene, each solver, and the manifest.
const folded = [];
addEventListener("beforeprint", () => {
  folded.push(...document.querySelectorAll("details:not([open], .raw)"));
  for (const part of folded) part.open = true;
});
addEventListener("afterprint", () => {
  for (const part of folded.splice(0)) part.open = false;
});
