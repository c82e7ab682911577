// Tables that sort and filter, pictures that enlarge. Without this script the page shows it all.
"use strict";
(() => {
  const MANY = 8; // rows; longer tables get a filter

  // "1 234.5", "−3 %" and "–" as numbers; text as it is.
  function value(row, column) {
    const cell = row.cells[column], text = cell.textContent.trim();
    if (cell.classList.contains("label")) return text;
    const number = parseFloat(text.replace(/[\s\u202f]/g, "").replace("\u2212", "-"));
    return Number.isNaN(number) ? -Infinity : number;
  }

  const words = new Intl.Collator("en", { numeric: true });
  function compare(a, b) {
    return typeof a === "string" ? words.compare(a, b) : a - b || 0;
  }

  function sort(table, column) {
    const heads = [...table.tHead.rows[0].cells], head = heads[column];
    const down = head.getAttribute("aria-sort") === "ascending";
    heads.forEach((other) => other.removeAttribute("aria-sort"));
    head.setAttribute("aria-sort", down ? "descending" : "ascending");
    const rows = [...table.tBodies[0].rows].map((row) => [value(row, column), row]);
    rows.sort(([a], [b]) => compare(a, b) * (down ? -1 : 1));
    table.tBodies[0].append(...rows.map(([, row]) => row));
  }

  function filter(table, text) {
    const wanted = text.toLowerCase().split(/\s+/).filter(Boolean);
    for (const row of table.tBodies[0].rows) {
      const found = row.textContent.toLowerCase();
      row.hidden = !wanted.every((word) => found.includes(word));
    }
  }

  function prepare(table) {
    const n = table.tBodies[0].rows.length;
    if (n < 2) return;
    [...table.tHead.rows[0].cells].forEach((head, column) => {
      if (!head.textContent) return;
      const button = document.createElement("button");
      button.type = "button";
      button.append(...head.childNodes);
      button.addEventListener("click", () => sort(table, column));
      head.append(button);
    });
    if (n <= MANY) return;
    const input = document.createElement("input");
    Object.assign(input, { type: "search", className: "filter", placeholder: "Filter rows",
      ariaLabel: "Filter rows of this table" });
    input.addEventListener("input", () => filter(table, input.value));
    table.parentNode.before(input);
  }

  function enlarge(figure) {
    const image = figure.querySelector("img"), button = document.createElement("button");
    Object.assign(button, { type: "button", className: "enlarge", title: "Enlarge" });
    image.replaceWith(button);
    button.append(image);
    button.addEventListener("click", () => {
      const dialog = document.createElement("dialog"), line = document.createElement("p");
      const words_of = document.createElement("span"), close = document.createElement("button");
      const large = image.cloneNode();
      words_of.textContent = figure.querySelector("figcaption").textContent;
      Object.assign(close, { type: "button", textContent: "Close" });
      close.addEventListener("click", () => dialog.close());
      large.addEventListener("click", () => large.classList.toggle("full"));
      dialog.addEventListener("click", (event) => event.target === dialog && dialog.close());
      dialog.addEventListener("close", () => dialog.remove());
      line.append(words_of, close);
      dialog.append(line, large);
      document.body.append(dialog);
      dialog.showModal();
    });
  }

  document.querySelectorAll(".wide > table").forEach(prepare);
  document.querySelectorAll("figure").forEach(enlarge);

  // what is folded is printed, too
  const folds = () => [...document.querySelectorAll("details.fold:not([open])")];
  let opened = [];
  addEventListener("beforeprint", () => {
    opened = folds();
    opened.forEach((fold) => { fold.open = true; });
  });
  addEventListener("afterprint", () => opened.forEach((fold) => { fold.open = false; }));
})();
