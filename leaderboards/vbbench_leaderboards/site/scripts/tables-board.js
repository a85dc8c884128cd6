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
/* A board on the page: put there, and kept in step with the address. */
(function () {
  "use strict";
  const vbbench = window.vbbench;
  const place = document.getElementById("board");
  const BY = "dx";
  const OPTIONS = ["by", "order", "show", "find", "columns"];
  const ORDERS = ["up", "down"];

  /** @type {{state: any, change: (options: Record<string, string>) => void} | null} */
  let now = null;

  /**
   * @param {any} board as its data file has it
   * @param {any} state
   * @param {(options: Record<string, string>) => void} change called with what the reader chose
   */
  function show(board, state, change) {
    if (place.dataset.board !== board.key) {
      place.innerHTML = board.html; // written by the build, with every stranger's word escaped there
      place.dataset.board = board.key;
      wire();
    }
    place.setAttribute("aria-busy", "false");
    now = { state, change };
    apply(state.options);
  }

  /** @param {Record<string, string>} options */
  function apply(options) {
    const column = headOf(options.by) ? options.by : BY;
    const down = options.order ? options.order === "down" : vbbench.table.startsDown(column);
    const table = /** @type {HTMLTableElement} */ (document.getElementById("board-table"));
    vbbench.table.sort(table, column, down);
    const all = showsAll(options);
    table.classList.toggle("all", all);
    pressed(document.getElementById("more-columns"), all);
    choose(options);
    note(unknown(options));
    showMetric(vbbench.table.metricOf(column));
    say(column, down, table);
  }

  /** @param {string | undefined} name @returns {Element | null} */
  function headOf(name) {
    return name ? document.querySelector('#board-table th[data-column="' + CSS.escape(name) + '"]') : null;
  }

  /** @param {string | undefined} name @returns {boolean} whether it is a column that is shown on request */
  function isMore(name) {
    const head = headOf(name);
    return head !== null && head.classList.contains("more");
  }

  /** @param {Record<string, string>} options @returns {boolean} all columns, asked for or sorted by one of them */
  function showsAll(options) {
    return options.columns === "all" || isMore(options.by);
  }

  /** @param {Record<string, string>} options */
  function choose(options) {
    const chosen = options.show === undefined ? null : new Set(options.show.split(",").map(vbbench.state.decoded));
    for (const box of place.querySelectorAll("#chips input")) box.checked = chosen === null || chosen.has(box.value);
    const field = /** @type {HTMLInputElement} */ (document.getElementById("filter"));
    if (document.activeElement !== field) field.value = options.find || "";
    const count = vbbench.table.filter(place, options.find || "", chosen);
    document.getElementById("nothing-found").hidden = count > 0;
  }

  /** What the address asks for that this board does not have. @param {Record<string, string>} options @returns {string} */
  function unknown(options) {
    const names = new Set(Array.from(place.querySelectorAll("#chips input"), (box) => box.value));
    const shown = (options.show || "").split(",").filter(Boolean).map(vbbench.state.decoded);
    const said = [
      ...(options.by && !headOf(options.by) ? ["the column " + options.by] : []),
      ...shown.filter((name) => !names.has(name)).map((name) => "the solver " + (name || "with a damaged name")),
      ...(options.order && !ORDERS.includes(options.order) ? ["the order " + options.order] : []),
      ...Object.keys(options).filter((name) => !OPTIONS.includes(name)).map((name) => "an option " + name),
    ];
    return said.length ? "The address asks for what this board does not have: " + said.join(", ") + "." : "";
  }

  /** @param {string} text what the reader must know of this view; empty for nothing */
  function note(text) {
    const line = document.getElementById("board-note");
    line.textContent = text;
    line.hidden = !text;
  }

  /** @param {string} metric of which charts and differences are shown */
  function showMetric(metric) {
    const shown = place.querySelector('.pair[data-metric="' + metric + '"]') ? metric : BY;
    for (const part of place.querySelectorAll("[data-metric]")) part.hidden = part.dataset.metric !== shown;
    for (const button of place.querySelectorAll("[data-choose]")) pressed(button, button.dataset.choose === shown);
  }

  /** @param {string} column @param {boolean} down @param {HTMLTableElement} table */
  function say(column, down, table) {
    const head = headOf(column);
    const rows = table.querySelectorAll("tbody.rows > tr:not([hidden])").length;
    const order = down ? "largest first" : "smallest first";
    const count = rows + (rows === 1 ? " solver" : " solvers");
    const words = count + ", sorted by " + (head ? head.textContent.trim() : column) + ", " + order;
    const region = document.getElementById("board-says");
    if (region.textContent !== words) region.textContent = words;
  }

  /** @param {Element} button @param {boolean} on */
  function pressed(button, on) {
    button.setAttribute("aria-pressed", String(on));
  }

  /** Set options of the address; an empty one leaves it. @param {Record<string, string | undefined>} options */
  function set(options) {
    const next = { ...now.state.options, ...options };
    now.change(Object.fromEntries(Object.entries(next).filter(([, value]) => value !== undefined)));
  }

  /** @param {string} column */
  function sortBy(column) {
    const sorted = headOf(column).getAttribute("aria-sort");
    const down = sorted ? sorted === "ascending" : vbbench.table.startsDown(column);
    set({ by: column, order: down === vbbench.table.startsDown(column) ? undefined : down ? "down" : "up" });
  }

  function wire() {
    for (const button of place.querySelectorAll("[data-sort]")) {
      button.addEventListener("click", () => sortBy(button.dataset.sort));
    }
    for (const button of place.querySelectorAll("[data-choose]")) {
      button.addEventListener("click", () => set({ by: button.dataset.choose, order: undefined }));
    }
    document.getElementById("more-columns").addEventListener("click", function () {
      const all = showsAll(now.state.options);
      const unsorted = all && isMore(now.state.options.by) ? { by: undefined, order: undefined } : {};
      set({ columns: all ? undefined : "all", ...unsorted });
    });
    document.getElementById("filter").addEventListener("input", function (event) {
      set({ find: event.target.value || undefined });
    });
    document.getElementById("chips").addEventListener("change", function () {
      const boxes = Array.from(place.querySelectorAll("#chips input"));
      const on = boxes.filter((box) => box.checked).map((box) => encodeURIComponent(box.value));
      set({ show: on.length === boxes.length ? undefined : on.join(",") });
    });
  }

  /** @param {string} text what went wrong */
  function fail(text) {
    place.innerHTML = '<p class="note" role="alert"></p>';
    place.firstElementChild.textContent = text;
    delete place.dataset.board;
    place.setAttribute("aria-busy", "false");
  }

  vbbench.boards = { show, fail, note };
})();
