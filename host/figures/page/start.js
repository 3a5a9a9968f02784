// SPDX-License-Identifier: Apache-2.0

// Draws every figure of the page, and again where width or colours change.

const figures = [];
for (const holder of document.querySelectorAll("figure[data-kind]")) {
  const kind = holder.dataset.kind, box = holder.querySelector(".drawing"), tools = holder.querySelector(".tools"), name = holder.id;
  if (kind === "table") {
    const cells = row => [...row.cells].map(c => c.textContent.trim());
    const rows = () => [...holder.querySelectorAll("tr")].map(cells);
    tools.append(csvButton("CSV", name, rows));
    continue;
  }
  const data = JSON.parse(holder.querySelector("script").textContent);
  if (kind === "chart") {
    tools.append(csvButton("CSV", name, () => figureRows(data)));
    figures.push({ name, data, rows: () => figureRows(data), draw: () => chart(data, box) });
  } else {
    const view = new (kind === "pad" ? PadView : ContactView)(data, box);
    for (const [label, part, rows] of view.tables()) tools.append(csvButton(label, `${name}-${part}`, rows), " ");
    figures.push({ name, data, view, rows: view.tables()[0][2], draw: () => view.draw() });
  }
}
document.body.append(tip);
const drawAll = () => { hideTip(); figures.forEach(f => f.draw()); };
drawAll();
let width = innerWidth;
addEventListener("resize", () => { if (innerWidth !== width) { width = innerWidth; drawAll(); } });
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", drawAll);
matchMedia("print").addEventListener("change", drawAll);

// The contents: folded where they would cover the page; the section in sight is marked.
const contents = document.querySelector("nav details");
if (contents) {
  const wide = matchMedia("(min-width: 1200px)"), fold = () => { contents.open = wide.matches; };
  const links = contents.querySelectorAll("a"), heads = [...document.querySelectorAll("h2")];
  const mark = () => {
    const here = heads.filter(h => h.getBoundingClientRect().top < innerHeight / 3).length - 1;
    links.forEach((link, i) => i === here ? link.setAttribute("aria-current", "true") : link.removeAttribute("aria-current"));
  };
  wide.addEventListener("change", fold);
  contents.addEventListener("click", event => { if (event.target.closest("a")) fold(); });
  addEventListener("scroll", mark, { passive: true });
  fold();
  mark();
}
window.tactel = { figures, csvText };  // for tests and the console
