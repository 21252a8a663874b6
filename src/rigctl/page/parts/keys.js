// Keys of every page; nothing is done while something is being typed.
(() => {
  const typed = (target) => target.closest("input:not([type=range]):not([type=checkbox]), textarea, select, [contenteditable]");
  const press = (name) => {
    const found = document.querySelector(`[data-testid=${name}]`);
    if (!found || found.disabled) return false;
    found.click();
    return true;
  };
  // What is asked for while the page is drawn, or before the daemon hears it, is done once it can be.
  const soon = (act) => {
    let tries = 200;
    const go = () => act() || (tries-- > 0 && setTimeout(go, 50));
    go();
    return true;
  };
  const story = () => location.pathname.startsWith("/model");
  const undo = () => window.did_handshake && (emitEvent("undo"), true);
  const step = (number) => {
    const at = document.getElementById(`step-${number}`);
    if (!at) return false;
    at.scrollIntoView({ behavior: matchMedia("(prefers-reduced-motion: reduce)").matches ? "auto" : "smooth" });
    at.focus({ preventScroll: true });
    return true;
  };
  // Not as a modal window: the stop can be pressed while the list is open.
  window.listKeys = () => {
    const help = document.getElementById("keys");
    if (help.open) help.close();
    else help.show();
  };
  document.addEventListener("keydown", (event) => {
    const help = document.getElementById("keys");
    if (event.ctrlKey || event.altKey || event.metaKey || typed(event.target)) return;
    if (document.querySelector(".q-dialog")) return;
    let done = false;
    if (event.key === "?") {
      window.listKeys();
      done = true;
    } else if (event.key === "Escape" && help?.open) {
      help.close();
      done = true;
    } else if (/^[1-4]$/.test(event.key)) done = story() && soon(() => step(event.key));
    else if (event.key === "u" || event.key === "U") done = story() && !event.repeat && soon(undo);
    else if (event.key === " " && !event.target.closest("button, a, summary, [role=button], input, [role=checkbox]"))
      done = press("ghost-play") || press("play");
    if (done) event.preventDefault();
  });

  window.toStep = (number) => soon(() => step(number));

  // Marks the cell of a map that was clicked, and returns its place.
  window.chooseInMap = (event) => {
    const cell = event.target.closest("[data-cell]");
    if (!cell) return "";
    const table = cell.closest("table");
    for (const other of table.querySelectorAll("[data-cell]")) {
      other.setAttribute("aria-pressed", String(other === cell));
      other.tabIndex = other === cell ? 0 : -1;
    }
    for (const head of table.querySelectorAll(".heads th, tbody th")) head.classList.remove("here");
    cell.closest("tr").cells[0].classList.add("here");
    table.querySelector(".heads").cells[cell.closest("td").cellIndex].classList.add("here");
    return cell.dataset.cell;
  };

  // Arrows go from cell to cell of a map; the one that has the focus alone is reached by the tabulator.
  window.moveInMap = (event) => {
    const cell = event.target.closest("[data-cell]");
    const way = { ArrowLeft: [0, -1], ArrowRight: [0, 1], ArrowUp: [-1, 0], ArrowDown: [1, 0] }[event.key];
    if (!cell || !way) return;
    event.preventDefault();
    const rows = [...cell.closest("tbody").rows];
    let [row, column] = [rows.indexOf(cell.closest("tr")), cell.closest("td").cellIndex];
    for (;;) {
      row += way[0];
      column += way[1];
      const place = rows[row]?.cells[column];
      if (!place) return;
      const next = place.querySelector("[data-cell]");
      if (!next) continue;
      cell.tabIndex = -1;
      next.tabIndex = 0;
      next.focus();
      return;
    }
  };
})();
