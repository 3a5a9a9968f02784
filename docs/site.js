// Sets the equations of the site: mkdocs puts them between \( \) and \[ \].
document.addEventListener("DOMContentLoaded", () => {
  renderMathInElement(document.body, {
    delimiters: [
      { left: "\\(", right: "\\)", display: false },
      { left: "\\[", right: "\\]", display: true },
    ],
  });
});

// Tables that programs print keep their lines on a telephone: their letters become smaller.
document.addEventListener("DOMContentLoaded", () => {
  for (const code of document.querySelectorAll("pre > code")) {
    const columns = Math.max(...code.innerText.split("\n").filter(line => /\S(  +\S+){4}/.test(line)).map(line => line.length));
    if (columns > 0) code.style.fontSize = `min(.85em, calc((100vw - 2.2rem) / ${columns} / .61))`;
  }
});

// The button of a block copies what a reader types: the lines after "$ ", where there are such, without it.
document.addEventListener("click", event => {
  const button = event.target.closest("[data-clipboard-target]");
  if (!button) return;
  const typed = document.querySelector(button.dataset.clipboardTarget).innerText.match(/^\$ (?:.*\\\n)*.*$/gm);
  if (typed) button.setAttribute("data-clipboard-text", typed.map(command => command.slice(2)).join("\n"));
}, true);
