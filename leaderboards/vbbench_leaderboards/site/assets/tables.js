/* The table of a board: order, filter, columns, and the ranks by the metric that it is sorted by. */
"use strict";
const { make } = vbbench;
const boardView = (function () {
  const BY = "dx", BIG_IS_GOOD = ["coverage"];
  const OPTIONS = ["by", "order", "show", "find", "columns"], ORDERS = ["up", "down"];
  const place = document.getElementById("board"), byId = (name) => document.getElementById(name);
  const rowsOf = () => [...place.querySelectorAll("#board-table tbody.rows > tr")];
  const heads = () => [...byId("board-table").tHead.rows[0].cells];
  const headOf = (column) => heads().find((head) => head.dataset.column === column);
  const isMore = (column) => headOf(column)?.classList.contains("more") ?? false;
  const ranksOf = (row) => JSON.parse(row.cells[0].dataset.ranks);
  const pressed = (button, on) => button.setAttribute("aria-pressed", String(on));
  const startsDown = (column) => BIG_IS_GOOD.includes(column);

  let now = { options: {}, change: null };

  /** Show a board, as its data file has it, in a state; `change` is called with the options that the reader chose. */
  function show(board, options, change) {
    if (place.dataset.board !== board.key) {
      place.innerHTML = board.html; // written by the build, with every stranger's word escaped there
      place.dataset.board = board.key;
      explain(place);
      wire();
    }
    place.setAttribute("aria-busy", "false");
    now = { options, change };
    const column = headOf(options.by) ? options.by : BY, metric = metricOf(column);
    const down = options.order ? options.order === "down" : startsDown(column), all = showsAll();
    sort(column, metric, down);
    byId("board-table").classList.toggle("all", all);
    pressed(byId("more-columns"), all);
    choose(options);
    note(unknown(options));
    showMetric(metric);
    say(column, down);
  }

  /** The metric that ranks are shown by where a column sorts. */
  function metricOf(column) {
    const name = column.replace(/_(median|mean|p95)$/, ""), [row] = rowsOf();
    return row && Object.hasOwn(ranksOf(row), name) ? name : BY;
  }

  /** All columns are shown where they are asked for, or where one of them sorts. */
  const showsAll = () => now.options.columns === "all" || isMore(now.options.by);

  function sort(column, metric, down) {
    const all = heads(), index = all.indexOf(headOf(column)), main = all.indexOf(headOf(metric));
    for (const body of place.querySelectorAll("tbody.rows")) {
      const keys = new Map([...body.rows].map((row) => [row, valueOf(row, index, column, metric)]));
      body.append(...[...body.rows].sort((a, b) => compared(keys.get(a), keys.get(b), down)));
    }
    for (const row of rowsOf()) showRank(row.cells[0], ranksOf(row)[metric]);
    for (const row of place.querySelectorAll("thead tr, tbody.rows tr, tbody.quoted tr:not(:first-child)")) {
      [...row.cells].forEach((cell, n) => cell.classList.toggle("main", n === main || n === index));
    }
    for (const head of all) head.removeAttribute("aria-sort");
    all[index].setAttribute("aria-sort", down ? "descending" : "ascending");
  }

  function valueOf(row, index, column, metric) {
    const cell = row.cells[index], { value } = cell.dataset;
    if (column === "rank") return ranksOf(row)[metric][0];
    if (value === undefined) return cell.textContent.trim();
    return column === "solver" ? value : value === "" ? Infinity : Number(value);
  }

  /** What has no figure is last, whichever way the others are. */
  function compared(a, b, down) {
    const order = typeof a === "string" ? a.localeCompare(b, "en", { numeric: true }) : a === b ? 0 : a < b ? -1 : 1;
    return down && a !== Infinity && b !== Infinity ? -order : order;
  }

  function showRank(cell, [rank, best, worst]) {
    cell.textContent = String(rank);
    if (best !== worst) cell.append(make("span", { class: "ci" }, `${best}–${worst}`));
  }

  /** Show the rows whose words hold the text and whose solver is chosen; and the same solvers in the charts. */
  function choose(options) {
    const chosen = options.show === undefined ? null : options.show.split(",").map(vbbench.address.decoded);
    const words = (options.find || "").toLowerCase().split(/\s+/).filter(Boolean), shown = new Set(), field = byId("filter");
    for (const box of place.querySelectorAll("#chips input")) box.checked = !chosen || chosen.includes(box.value);
    if (document.activeElement !== field) field.value = options.find || "";
    for (const row of rowsOf()) {
      const { solver } = row.dataset;
      row.hidden = !words.every((word) => row.dataset.words.includes(word)) || (chosen && !chosen.includes(solver));
      if (!row.hidden) shown.add(solver);
    }
    for (const apart of place.querySelectorAll("tbody.apart")) {
      apart.hidden = !apart.nextElementSibling.querySelector("tr:not([hidden])");
    }
    for (const mark of place.querySelectorAll("svg [data-solver]")) {
      mark.toggleAttribute("hidden", !shown.has(mark.dataset.solver));
    }
    byId("nothing-found").hidden = shown.size > 0;
  }

  /** What the address asks for that this board does not have. */
  function unknown({ by, show: chosen = "", order, ...others }) {
    const names = [...place.querySelectorAll("#chips input")].map((box) => box.value);
    const said = [
      ...(by && !headOf(by) ? [`the column ${by}`] : []),
      ...chosen.split(",").filter(Boolean).map(vbbench.address.decoded).filter((name) => !names.includes(name))
        .map((name) => `the solver ${name || "with a damaged name"}`),
      ...(order && !ORDERS.includes(order) ? [`the order ${order}`] : []),
      ...Object.keys(others).filter((name) => !OPTIONS.includes(name)).map((name) => `an option ${name}`),
    ];
    return said.length ? `The address asks for what this board does not have: ${said.join(", ")}.` : "";
  }

  /** Say what the reader must know of this view; nothing if the text is empty. */
  function note(text) {
    Object.assign(byId("board-note"), { textContent: text, hidden: !text });
  }

  /** Show the charts and differences of a metric. */
  function showMetric(metric) {
    const shown = place.querySelector(`.pair[data-metric="${metric}"]`) ? metric : BY;
    for (const part of place.querySelectorAll("[data-metric]")) part.hidden = part.dataset.metric !== shown;
    for (const button of place.querySelectorAll("[data-choose]")) pressed(button, button.dataset.choose === shown);
  }

  function say(column, down) {
    const rows = rowsOf().filter((row) => !row.hidden).length, order = down ? "largest first" : "smallest first";
    const words = `${rows} ${rows === 1 ? "solver" : "solvers"}, sorted by ${headOf(column).textContent.trim()}, ${order}`;
    if (byId("board-says").textContent !== words) byId("board-says").textContent = words;
  }

  /** Set options of the address; an empty one leaves it. */
  function set(options) {
    now.change(Object.fromEntries(Object.entries({ ...now.options, ...options }).filter(([, value]) => value !== undefined)));
  }

  function sortBy(column) {
    const sorted = headOf(column).getAttribute("aria-sort"), down = sorted ? sorted === "ascending" : startsDown(column);
    set({ by: column, order: down === startsDown(column) ? undefined : down ? "down" : "up" });
  }

  function wire() {
    const on = (selector, event, act) => place.querySelectorAll(selector).forEach((one) => one.addEventListener(event, () => act(one)));
    on("[data-sort]", "click", (button) => sortBy(button.dataset.sort));
    on("[data-choose]", "click", (button) => set({ by: button.dataset.choose, order: undefined }));
    on("#more-columns", "click", () => {
      const all = showsAll(), unsorted = all && isMore(now.options.by) ? { by: undefined, order: undefined } : {};
      set({ columns: all ? undefined : "all", ...unsorted });
    });
    on("#filter", "input", (field) => set({ find: field.value || undefined }));
    on("#chips", "change", () => {
      const boxes = [...place.querySelectorAll("#chips input")], chosen = boxes.filter((box) => box.checked);
      set({ show: chosen.length === boxes.length ? undefined : chosen.map((box) => encodeURIComponent(box.value)).join(",") });
    });
  }

  function fail(text) {
    place.replaceChildren(make("p", { class: "note", role: "alert" }, text));
    delete place.dataset.board;
    place.setAttribute("aria-busy", "false");
  }

  return { show, fail, note };
})();

/** Say on hover what a word means, as the page explains it further down. */
function explain(root) {
  for (const word of root.querySelectorAll("[data-def]")) word.title = document.getElementById(word.dataset.def)?.textContent ?? "";
}
explain(document);

/* What the address asks for is what the page shows: a board's table, its sequences in the player, a
   solver's own page. */
(function () {
  const { parse, format, decoded } = vbbench.address;
  const picker = document.getElementById("picker"), listed = (name) => picker.dataset[name].split(" ").filter(Boolean);
  const [known, solvers] = [listed("boards"), listed("solvers")], { first } = picker.dataset;
  const TITLE = ": results of vbbench";
  const [board, player, page] = ["board", "player", "page"].map((name) => document.getElementById(name));
  const boards = document.getElementById("boards"), back = document.getElementById("back");
  let turn = 0, playing = "";

  const replace = (state) => history.replaceState(null, "", format(state));

  /** Bring a part to the top. Not by scrollIntoView, after which a browser's Tab key would begin there. */
  function reach(element) {
    const room = parseFloat(getComputedStyle(document.documentElement).scrollPaddingTop) || 0;
    scrollTo({ top: element.getBoundingClientRect().top + scrollY - room, behavior: "instant" });
  }

  /** Where a view begins: read out, and brought to the top. */
  function arrive(place, top) {
    place.querySelector("[tabindex='-1']")?.focus({ preventScroll: true });
    if (top) reach(top);
  }

  /** The board nearest to what is wanted: of the split, unless a tier is asked for that it does not have. */
  function nearest(split, protocol, tier, elsewhere) {
    const own = known.filter((key) => key.startsWith(`${split}/`)), which = `/${protocol}-${tier}`;
    return (
      own.find((key) => key === split + which) ||
      own.find((key) => key.endsWith(`-${tier}`)) ||
      (elsewhere && known.find((key) => key.endsWith(which))) ||
      own.find((key) => key.startsWith(`${split}/${protocol}-`)) ||
      own[0] ||
      first
    );
  }

  /** Links of the picker lead on from the board that is shown, to the same view. */
  function aim(key, on) {
    const [, split, protocol, tier] = key.match(/^(.*)\/(.*)-([^-]*)$/);
    for (const link of picker.querySelectorAll("a")) {
      const own = link.dataset, here = own.split === split || own.protocol === protocol || own.tier === tier;
      const to = nearest(own.split || split, own.protocol || protocol, own.tier || tier, Boolean(own.tier));
      link.href = format({ board: to, ...on });
      if (here) link.setAttribute("aria-current", "true");
      else link.removeAttribute("aria-current");
    }
    const kept = document.getElementById("kept");
    if (kept?.querySelector("[aria-current]")) kept.open = true;
  }

  /** Show one place and no other; the player leads back to the table of its board. */
  function only(place, key = "") {
    if (place !== player && playing) {
      vbbench.player.unmount();
      playing = "";
    }
    for (const other of [board, player, page]) other.hidden = other !== place;
    document.body.dataset.view = place.id;
    back.hidden = !key;
    if (key) back.firstElementChild.href = format({ board: key });
  }

  function showTable(found, options) {
    only(board);
    boardView.show(found, options, (chosen) => {
      replace({ board: found.key, options: chosen });
      showTable(found, chosen);
    });
  }

  async function showPlayer(found, options, own) {
    if (!vbbench.player) {
      document.head.append(make("link", { rel: "stylesheet", href: "assets/player.css" }));
      await vbbench.script("assets/player.js");
    }
    if (own !== turn) return;
    const arrives = !playing;
    if (playing) vbbench.player.unmount();
    only(player, found.key);
    playing = found.key;
    document.title = `Sequences of ${found.words}${TITLE}`;
    const onState = (shown) => replace({ board: found.key, view: "play", options: shown });
    vbbench.player.mount(player, { board: found, state: options, onState });
    if (arrives) reach(back);
  }

  async function showSolver(name, own) {
    const { html } = await vbbench.load(`pages/solver/${name}`);
    if (own !== turn) return;
    page.innerHTML = html; // written by the build, with every stranger's word escaped there
    document.title = name + TITLE;
    only(page);
    scrollTo({ top: 0, behavior: "instant" });
    arrive(page, document.body);
  }

  function showUnknown(parts) {
    const words = parts[0] === "solver" ? "No solver of this name is here" : "No board of this name is here";
    page.replaceChildren(
      make("h1", { id: "missing-title", tabindex: "-1" }, parts.length === 2 ? words : "There is no such page"),
      make("p", {}, make("code", {}, decoded(location.hash) || location.hash)),
      make("p", {}, make("a", { href: "#/" }, "All solvers and boards")),
    );
    document.title = `No such page${TITLE}`;
    only(page);
    arrive(page, document.body);
  }

  async function showBoard(state, own) {
    const key = state.kind === "board" ? state.board : first, came = document.body.dataset.view;
    aim(key, { view: "", options: {} });
    const found = await vbbench.load(key), { options, view } = state;
    if (own !== turn) return;
    document.title = `${found.title}, ${found.protocol}, ${found.tier}${TITLE}`;
    if (view === "play" && found.playable.length) await showPlayer(found, options, own);
    else {
      showTable(found, options);
      if (came && came !== "board") arrive(board);
      if (view === "play") boardView.note("Its sequences cannot be watched: this page was built without them.");
    }
    const narrow = matchMedia("(max-width: 48rem)").matches;
    if (own === 1 && !playing && state.kind === "board") reach(narrow ? board : boards);
  }

  async function route() {
    const state = parse(location.hash), away = document.body.dataset.view === "page";
    if (state === null && turn > 0 && !away) return;
    const own = ++turn, { kind, ...wanted } = state || { kind: "front", options: {} };
    try {
      if (kind === "front" || (kind === "board" && known.includes(wanted.board))) await showBoard({ kind, ...wanted }, own);
      else if (kind === "solver" && solvers.includes(wanted.solver)) await showSolver(wanted.solver, own);
      else showUnknown(wanted.parts);
      if (!away) return;
      if (state === null) document.querySelector(location.hash)?.scrollIntoView({ behavior: "instant" });
      else if (kind === "front") scrollTo({ top: 0, behavior: "instant" });
      else if (kind === "board") reach(boards);
    } catch (error) {
      only(board);
      boardView.fail(`This cannot be shown: ${error.message}.`);
    }
  }

  addEventListener("hashchange", route);
  route();
})();
