/* The table of a board: sorting, filtering, columns, and the ranks by the metric that it is sorted by. */
(function () {
  "use strict";
  const vbbench = window.vbbench;
  const FALLBACK = "dx";
  const BIG_IS_GOOD = ["coverage"];

  /** @param {string} column @returns {string} the metric that ranks are shown by */
  function metricOf(column) {
    const name = column.replace(/_(median|mean|p95)$/, "");
    const row = document.querySelector("#board-table tbody.rows > tr");
    return row && Object.hasOwn(JSON.parse(row.cells[0].dataset.ranks), name) ? name : FALLBACK;
  }

  /** @param {HTMLTableRowElement} row @param {number} index @param {string} column @param {string} metric */
  function valueOf(row, index, column, metric) {
    const cell = row.cells[index];
    if (column === "rank") return JSON.parse(cell.dataset.ranks)[metric][0];
    if (cell.dataset.value === undefined) return cell.textContent.trim();
    if (column === "solver") return cell.dataset.value;
    return cell.dataset.value === "" ? Infinity : Number(cell.dataset.value);
  }

  /** @param {any} a @param {any} b @returns {number} */
  function compared(a, b) {
    if (typeof a === "string") return a.localeCompare(b, "en", { numeric: true });
    return a === b ? 0 : a < b ? -1 : 1;
  }

  /**
   * @param {HTMLTableElement} table
   * @param {string} column
   * @param {boolean} down largest first
   */
  function sort(table, column, down) {
    const heads = Array.from(table.tHead.rows[0].cells);
    const index = heads.findIndex((head) => head.dataset.column === column);
    if (index < 0) return;
    const metric = metricOf(column);
    const turn = down ? -1 : 1;
    for (const body of table.querySelectorAll("tbody.rows")) {
      const rows = Array.from(body.rows);
      const keys = new Map(rows.map((row) => [row, valueOf(row, index, column, metric)]));
      rows.sort(function (a, b) {
        const [one, two] = [keys.get(a), keys.get(b)];
        if (one === Infinity || two === Infinity) return compared(one, two);
        return turn * compared(one, two);
      });
      body.append(...rows);
      showRanks(rows, metric);
    }
    const main = heads.findIndex((head) => head.dataset.column === metric);
    for (const row of table.querySelectorAll("thead tr, tbody.rows tr, tbody.quoted tr:not(:first-child)")) {
      Array.from(row.cells).forEach((cell, n) => cell.classList.toggle("main", n === main || n === index));
    }
    heads.forEach(function (head) {
      head.removeAttribute("aria-sort");
    });
    heads[index].setAttribute("aria-sort", down ? "descending" : "ascending");
  }

  /** @param {HTMLTableRowElement[]} rows @param {string} metric */
  function showRanks(rows, metric) {
    for (const row of rows) {
      const cell = row.cells[0];
      const [rank, best, worst] = JSON.parse(cell.dataset.ranks)[metric];
      cell.textContent = String(rank);
      if (best === worst) continue;
      const interval = document.createElement("span");
      interval.className = "ci";
      interval.textContent = best + "–" + worst;
      cell.append(interval);
    }
  }

  /**
   * Show the rows whose words hold the text and whose solver is chosen; and the same solvers in the charts.
   * @param {HTMLElement} board
   * @param {string} text
   * @param {Set<string> | null} chosen null for all
   * @returns {number} how many are shown
   */
  function filter(board, text, chosen) {
    const words = text.toLowerCase().split(/\s+/).filter(Boolean);
    const shown = new Set();
    for (const row of board.querySelectorAll("#board-table tbody.rows > tr")) {
      const fits = words.every((word) => row.dataset.words.includes(word));
      row.hidden = !fits || (chosen !== null && !chosen.has(row.dataset.solver));
      if (!row.hidden) shown.add(row.dataset.solver);
    }
    for (const apart of board.querySelectorAll("#board-table tbody.apart")) {
      apart.hidden = !apart.nextElementSibling.querySelector("tr:not([hidden])");
    }
    for (const mark of board.querySelectorAll("svg [data-solver]")) {
      mark.toggleAttribute("hidden", !shown.has(mark.getAttribute("data-solver")));
    }
    return shown.size;
  }

  /** @param {string} column @returns {boolean} whether the first click sorts the largest first */
  function startsDown(column) {
    return BIG_IS_GOOD.includes(column);
  }

  vbbench.table = { sort, filter, metricOf, startsDown };
})();
