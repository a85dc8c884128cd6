/* Numbers as the build writes them (site/words.py): two or three significant digits, points of a column in line. */
"use strict";
const { make } = vbbench;
const figures = vbbench.figures = (function () {
  /** The power of ten of a number's first digit, 0 for 0. */
  const power = (value) => (value ? Number(Math.abs(value).toExponential().split("e")[1]) : 0);
  const toThreeDigits = (value) => Number(value.toPrecision(3));

  /** Decimals of a column of figures. */
  function decimals(values) {
    const sizes = values.filter((value) => value).map(Math.abs);
    return Math.min(4, Math.max(2, 1 - power(sizes.length ? Math.min(...sizes) : 1)));
  }

  /** Decimals of a figure in a column of `most`. */
  function figureDecimals(value, most) {
    return value ? Math.min(most, Math.max(0, 2 - power(toThreeDigits(value)))) : most;
  }

  function figure(value, most) {
    const digits = figureDecimals(value, most), range = { minimumFractionDigits: digits, maximumFractionDigits: digits };
    const shown = (digits ? value : toThreeDigits(value)).toLocaleString("en", range); // rounded once
    return value > 0 && !Number(shown.replaceAll(",", "")) ? "<" + (10 ** -most).toFixed(most) : shown;
  }

  const signed = (value, most) => (value < 0 ? "−" : "+") + figure(Math.abs(value), most);

  function chance(p) {
    if (p === null) return "–";
    return p < 0.0001 ? "< 0.0001" : p.toFixed(p < 0.1 ? 4 : 2);
  }

  return { decimals, figure, figureDecimals, signed, chance };
})();

/* The table of a board: order, filter, columns, and the ranks by the metric that it is sorted by. */
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

/* Two solvers of a board next to one another: their differences, sequence by sequence, and where they differ most. */
const comparison = (function () {
  const { decimals, figure, signed, figureDecimals, chance } = figures;
  const BY = "dx", LEVEL = 0.05, SHOWN = 5;

  /** The errors and differences of a board's solvers, and which sequences can be watched. */
  async function load(board) {
    const found = await vbbench.load(`pages/pairs/${board.key}`);
    const index = board.playable.length ? await vbbench.load(`player/${board.split}`).catch(() => null) : null;
    return { ...found, films: new Set(index ? index.sequences : []) };
  }

  /** The two solvers and the metric that the address asks for; where it asks for none, the two that lead. */
  function chosen(found, options) {
    const { solvers } = found, by = Object.hasOwn(found.metrics, options.by || "") ? options.by : BY;
    const rank = (name) => found.metrics[by].capped[solvers.indexOf(name)] ?? Infinity;
    const order = [...solvers].sort((one, two) => rank(one) - rank(two));
    const a = solvers.includes(options.a) ? options.a : order.find((name) => name !== options.b);
    const b = solvers.includes(options.b) && options.b !== a ? options.b : order.find((name) => name !== a);
    return { a, b, by, missing: [options.a, options.b].filter((name) => name && !solvers.includes(name)) };
  }

  /** A − B of a metric: the build's figures, turned where the pair stands the other way. */
  function contrast({ found, a, b, rowsOf }, metric) {
    const [i, j] = [a, b].map((name) => found.solvers.indexOf(name));
    const [, , own] = found.pairs.find(([one, two]) => one === Math.min(i, j) && two === Math.max(i, j));
    const [difference, low, high, p, sequences, won] = own[metric], minus = (value) => (value === null ? null : -value);
    if (i < j) return { difference, low, high, p, sequences, won };
    const lost = rowsOf(metric).filter((row) => row.difference < 0).length;
    return { difference: minus(difference), low: minus(high), high: minus(low), p, sequences, won: lost };
  }

  /** Sequences that both have, with their errors and difference. */
  function paired(found, a, b, metric) {
    const [one, two] = [a, b].map((name) => found.metrics[metric].errors[found.solvers.indexOf(name)]);
    return found.sequences
      .map((sequence, n) => ({ sequence, a: one[n], b: two[n], difference: one[n] - two[n] }))
      .filter((row) => row.a !== null && row.b !== null);
  }

  /** Show it in a place, and return who is shown; `change` is called with what the reader chose. */
  function show(place, board, found, options, change) {
    const state = chosen(found, options), rowsOf = (metric) => paired(found, state.a, state.b, metric);
    const focused = place.contains(document.activeElement) && document.activeElement.id;
    const colours = Object.fromEntries(board.solvers.map((solver) => [solver.name, solver.colour]));
    const view = { ...state, board, found, rowsOf, rows: rowsOf(state.by), colours, metric: found.metrics[state.by] };
    place.replaceChildren(
      make("h3", { id: "comparison-title", tabindex: "-1" }, "Two solvers, sequence by sequence ",
        make("span", { class: "which" }, board.words)),
      chooser(view, change), verdict(view), table(view), extremes(view),
    );
    explain(place);
    if (focused) document.getElementById(focused)?.focus();
    return state;
  }

  const dot = (view, name) => make("span", { class: `dot c${view.colours[name]}` });
  const head = (text, n, ...parts) => make("th", { scope: "col", class: n ? "num" : undefined }, ...parts, text);

  function chooser(view, change) {
    const { a, b, by, found } = view, set = (next) => change({ a, b, by, ...next });
    const side = (name, other) => make("label", { class: "side" }, make("span", {}, name.toUpperCase()), dot(view, view[name]),
      make("select", { id: `side-${name}`, onchange: ({ target: { value } }) =>
        set({ [name]: value, ...(value === view[other] ? { [other]: view[name] } : {}) }) },
        ...found.solvers.map((solver) => make("option", { value: solver, selected: solver === view[name] ? "" : undefined }, solver))));
    const metrics = Object.entries(found.metrics).map(([key, metric]) =>
      make("button", { type: "button", id: `by-${key}`, "aria-pressed": String(key === by), "data-def": `def-${key}`,
        "aria-describedby": `def-${key}`, onclick: () => set({ by: key }) }, metric.name));
    return make("div", { class: "versus" }, side("a", "b"),
      make("button", { type: "button", id: "swap", class: "quiet", onclick: () => set({ a: b, b: a }) }, "Swap"),
      side("b", "a"), make("div", { class: "choices", role: "group", "aria-label": "Metric" }, ...metrics));
  }

  function verdict(view) {
    const own = contrast(view, view.by), most = decimals([own.difference]), fine = figureDecimals(own.difference || 1, most);
    const words = make("p", { class: "verdict", role: "status" });
    if (view.missing.length) words.append(`No solver ${view.missing.join(", ")} is on this board. `);
    if (own.difference === null) words.append("They share no sequence with this figure.");
    else if (own.p === null) words.append("Too few sequences, or too little time, for an interval: nothing is settled.");
    else if (own.p < LEVEL) {
      const ends = [own.low, own.high].map(Math.abs).sort((one, two) => one - two).map((end) => end.toFixed(fine));
      words.append(make("b", {}, own.difference < 0 ? view.a : view.b), ` is better: ${view.metric.name} is smaller by `,
        make("b", {}, `${figure(Math.abs(own.difference), most)} ${view.metric.unit}`),
        ` (${ends.join(" to ")}, p ${chance(own.p).replace(/^(?=\d)/, "= ")}).`);
    } else words.append(make("b", {}, "Nothing is settled"), `: the data are consistent with no difference (p = ${chance(own.p)}).`);
    return words;
  }

  function table(view) {
    const heads = ["Metric", "A", "B", "A − B, 95 % interval", "p", "A better in"], sides = { A: view.a, B: view.b };
    return make("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": "Table of differences" },
      make("table", { class: "plain stacked", id: "differences" },
        make("thead", {}, make("tr", {}, ...heads.map((text, n) => head(text, n, sides[text] ? dot(view, sides[text]) : "")))),
        make("tbody", {}, ...Object.keys(view.found.metrics).map((key) => line(view, key)))),
      make("p", { class: "note" }, "Capped means, as boards rank by them; intervals and p are those of vbbench compare: a " +
        "bootstrap of this pair over blocks of time. Ranks correct p for all pairs of a board."));
  }

  function line(view, key) {
    const metric = view.found.metrics[key], own = contrast(view, key);
    const [a, b] = [view.a, view.b].map((name) => metric.capped[view.found.solvers.indexOf(name)]);
    const most = decimals([a, b]), show = (value) => (value === null ? "–" : figure(value, most));
    const cell = (label, ...parts) => make("td", { class: "num", "data-label": label }, ...parts);
    const fine = decimals([own.difference]), places = figureDecimals(own.difference ?? 0, fine);
    const ends = own.low === null ? [] : [own.low, own.high].map((end) => (end < 0 ? "−" : "+") + Math.abs(end).toFixed(places));
    return make("tr", { "data-metric": key, class: key === view.by ? "main" : undefined },
      make("th", { scope: "row" }, `${metric.name} `, make("span", { class: "unit" }, metric.unit)),
      cell("A", show(a)), cell("B", show(b)),
      cell("A − B", own.difference === null ? "–" : signed(own.difference, fine),
        ...(ends.length ? [make("span", { class: "ci" }, ends.join(" to "))] : [])),
      cell("p", chance(own.p)), cell("A better in", `${own.won} of ${own.sequences}`));
  }

  function extremes(view) {
    const sorted = [...view.rows].sort((one, two) => one.difference - two.difference || one.sequence - two.sequence);
    const films = view.rows.filter((row) => view.found.films.has(row.sequence)).length;
    return make("section", { class: "extremes", "aria-labelledby": "extremes-title" },
      make("h4", { id: "extremes-title" }, "Where they differ most"),
      make("p", { class: "note" }, films ? `${films} of ${view.rows.length} sequences can be watched here.`
        : "The sequences cannot be watched: this page was built without them."),
      make("div", { class: "pair" },
        side(view, view.a, sorted.filter((row) => row.difference < 0).slice(0, SHOWN)),
        side(view, view.b, sorted.filter((row) => row.difference > 0).slice(-SHOWN).reverse())));
  }

  function side(view, name, rows) {
    const title = make("h5", {}, dot(view, name), `${name} is better`), most = decimals(rows.flatMap((row) => [row.a, row.b]));
    if (!rows.length) return make("div", {}, title, make("p", { class: "note" }, "In no sequence."));
    const heads = ["Sequence", "A", "B", `A − B, ${view.metric.unit}`].map((text, n) => head(text, n));
    const body = rows.map((row) => make("tr", { "data-sequence": row.sequence },
      make("th", { scope: "row" }, view.found.films.has(row.sequence)
        ? make("a", { href: watched(view, row.sequence) }, `Watch ${row.sequence}`) : String(row.sequence)),
      ...[figure(row.a, most), figure(row.b, most), signed(row.difference, most)].map((text) => make("td", { class: "num" }, text))));
    return make("div", {}, title, make("table", { class: "plain" },
      make("thead", {}, make("tr", {}, ...heads)), make("tbody", {}, ...body)));
  }

  /** The address at which the player shows both solvers in a sequence. */
  function watched({ board, a, b }, sequence) {
    return vbbench.address.format({ board: board.key, view: "play", options: { sequence, solvers: `${a},${b}` } });
  }

  return { load, show, watched };
})();

/** Say on hover what a word means, as the page explains it further down. */
function explain(root) {
  for (const word of root.querySelectorAll("[data-def]")) word.title = document.getElementById(word.dataset.def)?.textContent ?? "";
}
explain(document);

/* What the address asks for is what the page shows: a board's table, its sequences in the player, two of its solvers,
   a solver's own page. */
(function () {
  const { parse, format, decoded } = vbbench.address;
  const picker = document.getElementById("picker"), listed = (name) => picker.dataset[name].split(" ").filter(Boolean);
  const [known, solvers] = [listed("boards"), listed("solvers")], { first } = picker.dataset;
  const TITLE = ": results of vbbench";
  const [board, player, compared, page] = ["board", "player", "comparison", "page"].map((name) => document.getElementById(name));
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

  /** Show one place and no other; player and comparison lead back to the table of their board. */
  function only(place, key = "") {
    if (place !== player && playing) {
      vbbench.player.unmount();
      playing = "";
    }
    for (const other of [board, player, compared, page]) other.hidden = other !== place;
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

  async function showComparison(found, options, own) {
    const pairs = await comparison.load(found), arrives = document.body.dataset.view !== "comparison";
    if (own !== turn) return;
    const show = (state) => {
      const { a, b } = comparison.show(compared, found, pairs, state, (next) => {
        replace({ board: found.key, view: "compare", options: next });
        show(next);
      });
      document.title = `${a} and ${b} on ${found.words}${TITLE}`;
      aim(found.key, { view: "compare", options: { a, b } });
    };
    only(compared, found.key);
    show(options);
    if (arrives) arrive(compared, back);
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
    else if (view === "compare" && found.solvers.length > 1) await showComparison(found, options, own);
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

  document.addEventListener("keydown", (event) => {
    const free = !(event.target instanceof Element && event.target.closest("select, input"));
    const leaves = event.key === "Escape" && !event.defaultPrevented && free && document.body.dataset.view === "comparison";
    if (leaves) back.firstElementChild.click();
  });
  addEventListener("hashchange", route);
  route();
})();
