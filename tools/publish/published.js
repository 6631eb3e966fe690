// The history of published runs: choices filter its rows, a click on a heading sorts them, a second one the other way round.
const table = document.getElementById("history"), body = table.tBodies[0], choosers = [...document.querySelectorAll("select")];
for (const chooser of choosers) {
  const known = [...new Set([...body.rows].map((row) => row.dataset[chooser.name]))].sort();
  for (const value of ["", ...known]) chooser.append(new Option(value || "all", value));
  chooser.addEventListener("change", () => {
    for (const row of body.rows) row.hidden = choosers.some((one) => one.value && row.dataset[one.name] !== one.value);
  });
}
const value = (cell) => (cell.dataset.value === undefined ? cell.textContent : Number(cell.dataset.value));
const headings = [...table.tHead.rows[0].cells];
for (const [k, heading] of headings.entries()) {
  const sort = () => {
    const up = heading.getAttribute("aria-sort") !== "ascending";
    for (const other of headings) other.removeAttribute("aria-sort");
    heading.setAttribute("aria-sort", up ? "ascending" : "descending");
    const rows = [...body.rows].sort((a, b) => {
      const [x, y] = [value(a.cells[k]), value(b.cells[k])];
      return (up ? 1 : -1) * (x < y ? -1 : x > y ? 1 : 0);
    });
    body.append(...rows);
  };
  heading.addEventListener("click", sort);
  heading.addEventListener("keydown", (event) => {
    if (event.key !== "Enter" && event.key !== " ") return;
    event.preventDefault();
    sort();
  });
}
