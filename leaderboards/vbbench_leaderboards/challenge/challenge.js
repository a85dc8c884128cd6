// The page says which phase is open when it was made; whoever reads it later learns what holds now.
"use strict";

{
  const now = Date.now();
  const phases = [...document.querySelectorAll("[data-opens]")].map((row) => ({
    row,
    name: row.dataset.phase,
    last: row.dataset.last,
    first: row.dataset.first,
    opens: Date.parse(row.dataset.opens),
    closes: Date.parse(row.dataset.closes),
  }));
  for (const { row, opens, closes } of phases) {
    const open = opens <= now && now < closes;
    row.querySelector(".state").textContent = open ? "open" : now < opens ? "not open yet" : "closed";
    if (open) row.setAttribute("aria-current", "true");
    else row.removeAttribute("aria-current");
  }
  const open = phases.find(({ opens, closes }) => opens <= now && now < closes);
  const next = phases.find(({ opens }) => now < opens);
  const said = document.getElementById("now");
  if (open) said.textContent = `Phase ${open.name} is open, to the end of ${open.last} (UTC).`;
  else if (next) said.textContent = `No phase is open. Phase ${next.name} opens on ${next.first}.`;
  else said.textContent = `The challenge is over: its last phase closed after ${phases.at(-1).last}.`;
}
