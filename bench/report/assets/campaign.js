// Filter the table of runs by outcome and text; copy the command of a run.
const rows = [...document.querySelectorAll("#runs tbody tr")];
const text = document.getElementById("filter");
const outcome = document.getElementById("outcome");
const shown = document.getElementById("shown");

function filter() {
  const words = text.value.toLowerCase().split(/\s+/).filter(Boolean);
  let count = 0;
  for (const row of rows) {
    const fits = (!outcome.value || row.dataset.outcome === outcome.value) && words.every((word) => row.textContent.toLowerCase().includes(word));
    row.hidden = !fits;
    count += fits;
  }
  shown.textContent = `${count} of ${rows.length}`;
}

if (text) {
  text.addEventListener("input", filter);
  outcome.addEventListener("change", filter);
  filter();
}
for (const button of document.querySelectorAll("button[data-command]")) {
  button.addEventListener("click", async () => {
    await navigator.clipboard?.writeText(button.dataset.command);
    button.textContent = "copied";
  });
}
