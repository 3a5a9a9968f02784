// Sets the equations of the site: mkdocs puts them between \( \) and \[ \].
document.addEventListener("DOMContentLoaded", () => {
  renderMathInElement(document.body, {
    delimiters: [
      { left: "\\(", right: "\\)", display: false },
      { left: "\\[", right: "\\]", display: true },
    ],
  });
});

// The button of a block copies what a reader types: the lines after "$ ", where there are such, without it.
document.addEventListener("click", event => {
  const button = event.target.closest("[data-clipboard-target]");
  if (!button) return;
  const typed = document.querySelector(button.dataset.clipboardTarget).innerText.match(/^\$ (?:.*\\\n)*.*$/gm);
  if (typed) button.setAttribute("data-clipboard-text", typed.map(command => command.slice(2)).join("\n"));
}, true);
