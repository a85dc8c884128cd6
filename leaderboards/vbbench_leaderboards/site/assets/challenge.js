/* The page says which phase is open when it was made; whoever reads it later learns what holds now. */
"use strict";
(function () {
  const now = Date.now(), said = document.getElementById("now"), rows = [...document.querySelectorAll("[data-opens]")];
  const isLater = (row) => now < Date.parse(row.dataset.opens), isOpen = (row) => !isLater(row) && now < Date.parse(row.dataset.closes);
  for (const row of rows) {
    row.querySelector(".state").textContent = isOpen(row) ? "open" : isLater(row) ? "not open yet" : "closed";
    if (isOpen(row)) row.setAttribute("aria-current", "true");
    else row.removeAttribute("aria-current");
  }
  const open = rows.find(isOpen), next = rows.find(isLater);
  said.textContent = open ? open.dataset.open : next ? next.dataset.coming : said.dataset.over;
})();
