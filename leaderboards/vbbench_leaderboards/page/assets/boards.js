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
