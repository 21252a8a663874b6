// Hands the files that were dropped or chosen to the daemon, and goes where they are shown.
window.bringFiles = async (field, says) => {
  if (!field.files.length) return;
  const files = new FormData();
  for (const file of field.files) files.append("files", file);
  says.hidden = false;
  says.className = "note";
  says.textContent = `Bringing ${field.files.length} file${field.files.length > 1 ? "s" : ""} …`;
  try {
    const answer = await fetch(field.dataset.address, { method: "POST", body: files });
    const said = await answer.json();
    if (answer.ok) {
      location.href = said.address;
      return;
    }
    says.textContent = said.detail;
  } catch (error) {
    says.textContent = "The daemon did not take the files: see whether it still runs.";
  }
  says.className = "verdict bad";
  field.value = "";
};
