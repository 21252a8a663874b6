// Hands the files that were dropped or chosen to the daemon, and goes where they are shown. What
// takes more than a second says how far it is, and can be ended; until then nothing else is taken.
const UNSAID_MS = 1000;

window.bringFiles = (field) => {
  if (!field.files.length) return;
  const placed = (part) => field.parentElement.querySelector(part);
  const [waits, says, left, bar, failed] = [
    ".waiting", ".waiting [role=status]", ".waiting .note", "progress", "[role=alert]",
  ].map(placed);
  const files = new FormData();
  for (const file of field.files) files.append("files", file);
  const name = `${field.files.length} file${field.files.length > 1 ? "s" : ""}`;
  const asked = new XMLHttpRequest();
  const began = performance.now();
  let [sent, of] = [0, 0];
  const held = document.activeElement === field;
  const busy = (is) => {
    field.disabled = is;
    // What is dropped meanwhile would be opened in the place of the page.
    const refuse = is ? (event) => event.preventDefault() : null;
    [field.parentElement.ondragover, field.parentElement.ondrop] = [refuse, refuse];
  };

  const show = () => {
    const gone = (performance.now() - began) / 1000;
    waits.hidden = 1000 * gone < UNSAID_MS;
    const share = of ? sent / of : 0;
    const step = share < 1 ? "they are on their way" : "all is there, and is being read";
    const told = `Bringing ${name}: ${step}`;
    // Set when it changes alone: it is read out.
    if (says.textContent !== told) says.textContent = told;
    bar.value = share;
    const about = share > 0 && share < 1
      ? `, about ${Math.max(1, Math.round((gone * (1 - share)) / share))} s left` : "";
    left.textContent = `${Math.floor(gone)} s gone${about}; ${mb(sent)} of ${mb(of)} MB are there.`;
  };
  const ticks = setInterval(show, 250);
  const end = (words) => {
    clearInterval(ticks);
    waits.hidden = true;
    failed.textContent = words;
    failed.className = words ? "verdict bad" : "";
    failed.hidden = !words;
    field.value = "";
    busy(false);
    if (held) field.focus();
  };
  asked.upload.onprogress = (event) => { [sent, of] = [event.loaded, event.total]; };
  asked.onload = () => {
    const said = answer(asked.responseText);
    if (asked.status < 300 && said.address) {
      clearInterval(ticks);
      busy(false);
      location.href = said.address;
    } else end(said.detail || "The daemon did not take the files: see whether it still runs.");
  };
  asked.onerror = () => end("The daemon did not take the files: see whether it still runs.");
  asked.onabort = () => end("");
  placed("button").onclick = () => asked.abort();
  failed.hidden = true;
  busy(true);
  asked.open("POST", field.dataset.address);
  asked.send(files);
};

const mb = (bytes) => (bytes / 1e6).toFixed(bytes < 1e7 ? 1 : 0);

const answer = (text) => {
  try { return JSON.parse(text); } catch { return {}; }
};
