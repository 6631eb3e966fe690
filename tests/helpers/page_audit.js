
// Run on a page by tests/helpers/browser.py: what overlaps, sticks out, was asked for, went wrong, or hinders (axe-core).
const faults = [];
addEventListener("error", (event) => faults.push(`error: ${event.message}`));
for (const one of document.querySelectorAll("details")) one.open = true;
for (const one of document.querySelectorAll(".panels figure")) one.style.contentVisibility = "visible";
for (const svg of document.querySelectorAll("svg")) {
  const frame = svg.getBoundingClientRect();
  const texts = [...svg.querySelectorAll("text")].map((text) => [text.textContent, text.getBoundingClientRect()]);
  texts.forEach(([text, box], at) => {
    const letters = parseFloat(getComputedStyle(svg).fontSize) * svg.getScreenCTM()?.a;  // none of a hidden drawing
    if (svg.closest(".map") && (letters < 9 || letters > 18)) faults.push(`letters of ${letters.toFixed(1)} px: ${text}`);
    if (box.left < frame.left - 1 || box.right > frame.right + 1 || box.top < frame.top - 1 || box.bottom > frame.bottom + 1) {
      faults.push(`outside its drawing: ${text}`);
    }
    for (const [other, its] of texts.slice(0, at)) {
      const across = Math.min(box.right, its.right) - Math.max(box.left, its.left);
      const upright = Math.min(box.bottom, its.bottom) - Math.max(box.top, its.top);
      if (across > 0.5 && upright > 0.3 * Math.min(box.height, its.height)) faults.push(`overlap: ${text} and ${other}`);
    }
  });
}
for (const part of document.querySelectorAll("td, th, h1, h2, h3, p, dt, dd, button, summary, li")) {
  const range = document.createRange();
  range.selectNodeContents(part);
  const text = range.getBoundingClientRect();
  const box = part.getBoundingClientRect();
  if (text.width === 0) continue;
  if (text.right > box.right + 2 || text.left < box.left - 2) faults.push(`too wide: ${part.textContent.trim().slice(0, 60)}`);
}
for (const cell of document.querySelectorAll("td, th")) {
  for (const texts = document.createTreeWalker(cell, NodeFilter.SHOW_TEXT); texts.nextNode(); ) {
    for (const { 0: word, index } of texts.currentNode.data.matchAll(/(?<!\S)\w[.\w]{0,10}(?:-\d{1,2})?(?![^\s,;:])/g)) {
      const range = document.createRange();
      range.setStart(texts.currentNode, index);
      range.setEnd(texts.currentNode, index + word.length);
      const lines = new Set([...range.getClientRects()].map((box) => Math.round(box.top)));
      const sentence = word.includes("-") && cell.textContent.trim().length > 20; // in which a number may end a line after e-
      if (lines.size > 1 && !sentence) faults.push(`broken word: ${word} in ${cell.textContent.trim().slice(0, 60)}`);
    }
  }
}
const root = document.documentElement;
const printed = location.pathname.endsWith("printed.html");  // where nobody can scroll
for (const wide of document.querySelectorAll(".wide, .table-wrapper")) {
  const whole = printed || (root.clientWidth <= 400 && wide.matches(".wide"));
  if (whole && wide.scrollWidth > wide.clientWidth + 1) faults.push(`scrolls: ${wide.textContent.trim().slice(0, 60)}`);
}
if (root.scrollWidth > root.clientWidth) faults.push(`the page is ${root.scrollWidth} px wide`);
for (const { name } of performance.getEntriesByType("resource")) {
  if (!/^file:.*\/_(static|images)\//.test(name)) faults.push(`asked for ${name}`);  // a page of the documentation has files beside it
}
const dark = matchMedia("(prefers-color-scheme: dark)").matches;
const drawn = document.querySelectorAll("figure svg").length;
const accessible = window.axe ? axe.run(document, { resultTypes: ["violations"] }) : Promise.resolve({ violations: [] });
accessible.then(({ violations }) => {
  for (const { id, impact, nodes } of violations) {
    if (impact !== "minor") faults.push(`${id}: ${nodes.slice(0, 3).map((node) => node.html.slice(0, 200))}`);
  }
  parent.postMessage(JSON.stringify({ width: root.clientWidth, dark, drawn, faults }), "*");
});
