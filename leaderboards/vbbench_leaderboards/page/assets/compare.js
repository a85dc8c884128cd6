/* Two solvers of a board side by side: their differences, sequence by sequence, and where they differ most. */
(function () {
  "use strict";
  const vbbench = window.vbbench;
  const { decimals, figure, signed, figureDecimals, chance } = vbbench.figures;
  const BY = "dx";
  const LEVEL = 0.05;
  const SHOWN = 5;

  /**
   * An element; text is text, whoever wrote it.
   * @param {string} name @param {Record<string, any>} facts attributes; `on…` are listeners
   * @param {...(Node | string)} parts @returns {HTMLElement}
   */
  function make(name, facts, ...parts) {
    const made = document.createElement(name);
    for (const [key, value] of Object.entries(facts)) {
      if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
      else if (value !== undefined) made.setAttribute(key, value);
    }
    made.append(...parts);
    return made;
  }

  /** @param {any} board @returns {Promise<any>} the errors and differences, and which sequences can be watched */
  async function load(board) {
    const found = await vbbench.load("pages/pairs/" + board.key);
    const index = board.playable.length ? await vbbench.load("player/" + board.split).catch(() => null) : null;
    return { ...found, films: new Set(index ? index.sequences : []) };
  }

  /**
   * The two solvers and the metric that the address asks for; where it asks for none, the two that lead.
   * @param {any} board @param {any} found @param {Record<string, string>} options
   */
  function chosen(board, found, options) {
    const by = Object.hasOwn(found.metrics, options.by || "") ? options.by : BY;
    const capped = found.metrics[by].capped;
    const rank = (name) => capped[found.solvers.indexOf(name)] ?? Infinity;
    const order = [...found.solvers].sort((one, two) => rank(one) - rank(two));
    const a = found.solvers.includes(options.a) ? options.a : order.find((name) => name !== options.b);
    const b = found.solvers.includes(options.b) && options.b !== a ? options.b : order.find((name) => name !== a);
    const missing = ["a", "b"].filter((side) => options[side] && !found.solvers.includes(options[side]));
    return { a, b, by, missing: missing.map((side) => options[side]) };
  }

  /** A − B of a metric: the build's figures, turned where the pair stands the other way. */
  function contrast(found, a, b, metric) {
    const [i, j] = [found.solvers.indexOf(a), found.solvers.indexOf(b)];
    const [, , own] = found.pairs.find(([one, two]) => one === Math.min(i, j) && two === Math.max(i, j));
    const [difference, low, high, p, sequences, won] = own[metric];
    if (i < j || difference === null) return { difference, low, high, p, sequences, won };
    const minus = (value) => (value === null ? null : -value);
    const errors = found.metrics[metric].errors;
    const lost = errors[i].filter((value, n) => value !== null && errors[j][n] !== null && value < errors[j][n]).length;
    return { difference: -difference, low: minus(high), high: minus(low), p, sequences, won: lost };
  }

  /** Sequences that both have, with their errors and difference. */
  function paired(found, a, b, metric) {
    const [one, two] = [a, b].map((name) => found.metrics[metric].errors[found.solvers.indexOf(name)]);
    return found.sequences
      .map((sequence, n) => ({ sequence, a: one[n], b: two[n], difference: one[n] - two[n] }))
      .filter((row) => row.a !== null && row.b !== null);
  }

  /**
   * @param {HTMLElement} place @param {any} board @param {any} found as `load` gives it
   * @param {Record<string, string>} options
   * @param {(options: Record<string, string>) => void} change called with what the reader chose
   * @returns {{a: string, b: string, by: string}} who is shown
   */
  function show(place, board, found, options, change) {
    const state = chosen(board, found, options);
    const rows = paired(found, state.a, state.b, state.by);
    const focused = document.activeElement && place.contains(document.activeElement) && document.activeElement.id;
    const colours = Object.fromEntries(board.solvers.map((solver) => [solver.name, solver.colour]));
    const view = { ...state, board, found, rows, colours, metric: found.metrics[state.by] };
    place.replaceChildren(
      heading(view), chooser(view, change), verdict(view), table(view),
      make("div", { class: "pair" }, ...vbbench.pairCharts(view)), extremes(view),
    );
    if (focused) document.getElementById(focused)?.focus();
    return state;
  }

  const dot = (view, name) => make("span", { class: "dot c" + view.colours[name] });

  function heading(view) {
    return make("h3", { id: "comparison-title", tabindex: "-1" }, "Two solvers, sequence by sequence ",
      make("span", { class: "which" }, view.board.words));
  }

  function chooser(view, change) {
    const set = (next) => change({ a: view.a, b: view.b, by: view.by, ...next });
    const side = (name, other) => make("label", { class: "side" }, make("span", {}, name.toUpperCase()), dot(view, view[name]),
      make("select", { id: "side-" + name, onchange: (event) => set({ [name]: event.target.value,
        ...(event.target.value === view[other] ? { [other]: view[name] } : {}) }) },
        ...view.found.solvers.map((solver) =>
          make("option", { value: solver, selected: solver === view[name] ? "" : undefined }, solver))));
    const metrics = Object.entries(view.found.metrics).map(([key, metric]) =>
      make("button", { type: "button", id: "by-" + key, "aria-pressed": String(key === view.by), "data-def": "def-" + key,
        "aria-describedby": "def-" + key, onclick: () => set({ by: key }) }, metric.name));
    return make("div", { class: "versus" }, side("a", "b"),
      make("button", { type: "button", id: "swap", class: "quiet", onclick: () => set({ a: view.b, b: view.a }) }, "Swap"),
      side("b", "a"), make("div", { class: "choices", role: "group", "aria-label": "Metric" }, ...metrics));
  }

  function verdict(view) {
    const own = contrast(view.found, view.a, view.b, view.by);
    const words = make("p", { class: "verdict", role: "status" });
    const most = decimals([own.difference]), fine = figureDecimals(own.difference || 1, most);
    if (view.missing.length) words.append("No solver " + view.missing.join(", ") + " is on this board. ");
    if (own.difference === null) words.append("They share no sequence with this figure.");
    else if (own.p === null) words.append("Too few sequences, or too little time, for an interval: nothing is settled.");
    else if (own.p < LEVEL) {
      const better = own.difference < 0 ? view.a : view.b;
      const ends = [own.low, own.high].map(Math.abs).sort((one, two) => one - two).map((end) => end.toFixed(fine));
      words.append(make("b", {}, better), ` is better: ${view.metric.name} is smaller by `,
        make("b", {}, figure(Math.abs(own.difference), most) + " " + view.metric.unit),
        ` (${ends.join(" to ")}, p ${chance(own.p).replace(/^(?=\d)/, "= ")}).`);
    } else words.append(make("b", {}, "Nothing is settled"), ": the data are consistent with no difference (p = " + chance(own.p) + ").");
    return words;
  }

  function table(view) {
    const heads = ["Metric", "A", "B", "A − B, 95 % interval", "p", "A better in"];
    const side = (n) => (n === 1 ? dot(view, view.a) : n === 2 ? dot(view, view.b) : "");
    return make("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": "Table of differences" },
      make("table", { class: "plain stacked", id: "differences" },
        make("thead", {}, make("tr", {}, ...heads.map((head, n) =>
          make("th", { scope: "col", class: n ? "num" : undefined }, side(n), head)))),
        make("tbody", {}, ...Object.keys(view.found.metrics).map((key) => line(view, key)))),
      make("p", { class: "note" }, "Capped means, as boards rank by them; intervals and p are those of vbbench compare: a " +
        "bootstrap of this pair over blocks of time. Ranks correct p for all pairs of a board."));
  }

  function line(view, key) {
    const metric = view.found.metrics[key], own = contrast(view.found, view.a, view.b, key);
    const [a, b] = [view.a, view.b].map((name) => metric.capped[view.found.solvers.indexOf(name)]);
    const most = decimals([a, b]), cell = (label, ...parts) => make("td", { class: "num", "data-label": label }, ...parts);
    const show = (value) => (value === null ? "–" : figure(value, most));
    const fine = decimals([own.difference]), places = own.difference === null ? 0 : figureDecimals(own.difference, fine);
    const ends = own.low === null ? [] : [own.low, own.high].map((end) => (end < 0 ? "−" : "+") + Math.abs(end).toFixed(places));
    return make("tr", { "data-metric": key, class: key === view.by ? "main" : undefined },
      make("th", { scope: "row" }, metric.name + " ", make("span", { class: "unit" }, metric.unit)),
      cell("A", show(a)), cell("B", show(b)),
      cell("A − B", own.difference === null ? "–" : signed(own.difference, fine),
        ...(ends.length ? [make("span", { class: "ci" }, ends.join(" to "))] : [])),
      cell("p", chance(own.p)), cell("A better in", own.won + " of " + own.sequences));
  }

  function extremes(view) {
    const sorted = [...view.rows].sort((one, two) => one.difference - two.difference || one.sequence - two.sequence);
    const sides = [
      [view.a, sorted.filter((row) => row.difference < 0).slice(0, SHOWN)],
      [view.b, sorted.filter((row) => row.difference > 0).slice(-SHOWN).reverse()],
    ];
    const films = view.rows.filter((row) => view.found.films.has(row.sequence)).length;
    const words = films
      ? `${films} of ${view.rows.length} sequences can be watched here.`
      : "The sequences cannot be watched: this page was built without them.";
    return make("section", { class: "extremes", "aria-labelledby": "extremes-title" },
      make("h4", { id: "extremes-title" }, "Where they differ most"), make("p", { class: "note" }, words),
      make("div", { class: "pair" }, ...sides.map(([name, rows]) => side(view, name, rows))));
  }

  function side(view, name, rows) {
    const title = make("h5", {}, dot(view, name), name + " is better");
    if (!rows.length) return make("div", {}, title, make("p", { class: "note" }, "In no sequence."));
    const most = decimals(rows.flatMap((row) => [row.a, row.b]));
    const heads = ["Sequence", "A", "B", "A − B"].map((head, n) =>
      make("th", { scope: "col", class: n ? "num" : undefined }, head + (n === 3 ? ", " + view.metric.unit : "")));
    const body = rows.map((row) => make("tr", { "data-sequence": row.sequence },
      make("th", { scope: "row" }, watch(view, row.sequence)),
      ...[figure(row.a, most), figure(row.b, most), signed(row.difference, most)].map((text) =>
        make("td", { class: "num" }, text))));
    return make("div", {}, title, make("table", { class: "plain" },
      make("thead", {}, make("tr", {}, ...heads)), make("tbody", {}, ...body)));
  }

  /** The number of a sequence, which leads to the player where it has the sequence. */
  function watch(view, sequence) {
    if (!view.found.films.has(sequence)) return make("span", {}, String(sequence));
    return make("a", { href: address(view, sequence) }, "Watch " + sequence);
  }

  function address(view, sequence) {
    const options = { sequence: String(sequence), solvers: view.a + "," + view.b };
    return vbbench.state.format({ board: view.board.key, view: "play", options });
  }

  vbbench.comparison = { load, show, address };
})();
