/* Numbers as the build writes them (site/words.py): two or three significant digits, points of a column in line. */
(function () {
  "use strict";

  /** @param {number} value @returns {number} the power of ten of its first digit, 0 for 0 */
  const power = (value) => (value ? Number(Math.abs(value).toExponential().split("e")[1]) : 0);

  /** @param {number} value @returns {number} */
  const toThreeDigits = (value) => Number(value.toPrecision(3));

  /** @param {(number | null)[]} values @returns {number} decimals of a column of figures */
  function decimals(values) {
    const sizes = values.filter((value) => value).map(Math.abs);
    return Math.min(4, Math.max(2, 1 - power(sizes.length ? Math.min(...sizes) : 1)));
  }

  /** @param {number} value @param {number} most @returns {number} */
  function figureDecimals(value, most) {
    return value ? Math.min(most, Math.max(0, 2 - power(toThreeDigits(value)))) : most;
  }

  /** @param {number} value @param {number} most decimals of its column @returns {string} */
  function figure(value, most) {
    const digits = figureDecimals(value, most);
    const shown = toThreeDigits(value).toLocaleString("en", {
      minimumFractionDigits: digits, maximumFractionDigits: digits,
    });
    return value > 0 && !Number(shown.replaceAll(",", "")) ? "<" + (10 ** -most).toFixed(most) : shown;
  }

  /** @param {number} value @param {number} most @returns {string} */
  function signed(value, most) {
    return (value < 0 ? "−" : "+") + figure(Math.abs(value), most);
  }

  /** @param {number | null} p @returns {string} */
  function chance(p) {
    if (p === null) return "–";
    return p < 0.0001 ? "< 0.0001" : p.toFixed(p < 0.1 ? 4 : 2);
  }

  window.vbbench.figures = { decimals, figure, figureDecimals, signed, chance };
})();
/* The charts of two solvers: an error against the other, and all differences in order. */
(function () {
  "use strict";
  const vbbench = window.vbbench;
  const SVG = "http://www.w3.org/2000/svg";
  const [WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM] = [460, 360, 52, 14, 30, 46];
  const HEAVY_TAILED = 20;

  /** @param {string} name @param {Record<string, any>} facts @param {...(Node | string)} parts */
  function draw(name, facts, ...parts) {
    const made = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(facts)) made.setAttribute(key, String(value));
    made.append(...parts);
    return made;
  }

  const words = (x, y, text, kind, anchor = "start") => draw("text", { x, y, class: kind, "text-anchor": anchor }, text);
  const rule = (x1, y1, x2, y2, kind) => draw("path", { class: kind, d: `M${x1} ${y1}L${x2} ${y2}` });
  const short = (value) => String(Number(value.toPrecision(3)));

  /** From values to places on the drawing, with round ticks; logarithmic where the values are heavy-tailed. */
  function axis(values, start, end) {
    const positive = values.filter((value) => value > 0);
    const high = Math.max(...values, 1e-9), low = positive.length ? Math.min(...positive) : high;
    const log = Math.min(...values) > 0 && high / low > HEAVY_TAILED;
    const [first, last] = log ? [low / 1.25, high * 1.25] : [Math.min(0, Math.min(...values) * 1.08), high * 1.08];
    const scaled = (value) => (log ? Math.log(value) : value);
    const place = (value) => start + ((scaled(value) - scaled(first)) / (scaled(last) - scaled(first))) * (end - start);
    return { place, log, ends: [log ? first : Math.max(first, 0), last], ticks: log ? powers(first, last) : steps(first, last) };
  }

  function powers(first, last) {
    const found = [];
    for (let power = Math.floor(Math.log10(first)); power <= Math.log10(last); power++) {
      for (const factor of [1, 3]) found.push(factor * 10 ** power);
    }
    return found.filter((value) => value >= first && value <= last);
  }

  function steps(first, last) {
    const rough = (last - first) / 6, power = 10 ** Math.floor(Math.log10(rough));
    const step = power * [1, 2, 2.5, 5, 10].find((factor) => power * factor >= rough * 0.999);
    const found = [];
    for (let n = Math.ceil(first / step); n * step <= last; n++) found.push(n * step);
    return found;
  }

  function frame(id, title, text, parts) {
    return draw("svg", { class: "chart", viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "group",
      "aria-labelledby": `${id}-title ${id}-desc` },
      draw("title", { id: id + "-title" }, title), draw("desc", { id: id + "-desc" }, text), ...parts);
  }

  function figureOf(chart, caption) {
    const [made, said] = [document.createElement("figure"), document.createElement("figcaption")];
    said.textContent = caption;
    made.append(chart, said);
    return made;
  }

  /** A dot for each sequence: A's error across, B's upwards. */
  function against(view) {
    const { rows, metric, a, b } = view;
    const values = rows.flatMap((row) => [row.a, row.b]);
    const x = axis(values, LEFT, WIDTH - RIGHT), y = axis(values, HEIGHT - BOTTOM, TOP);
    const { ends } = x;
    const scale = x.log ? " (log scale)" : "";
    const grid = x.ticks.flatMap((value) => [
      rule(LEFT, y.place(value), WIDTH - RIGHT, y.place(value), "grid"),
      words(LEFT - 8, y.place(value) + 4, short(value), "tick", "end"),
      words(x.place(value), HEIGHT - BOTTOM + 19, short(value), "tick", "middle"),
    ]);
    const parts = [...grid, rule(x.place(ends[0]), y.place(ends[0]), x.place(ends[1]), y.place(ends[1]), "even"),
      words(0, 14, `${metric.name} of B, ${b}, ${metric.unit}${scale}`, "axis-name"),
      words(WIDTH - RIGHT, HEIGHT - 6, `${metric.name} of A, ${a}, ${metric.unit}${scale}`, "axis-name", "end"),
      ...rows.map((row) => point(view, row, x.place(row.a), y.place(row.b)))];
    const text = `A dot for each of ${rows.length} sequences; above the line A is better, below it B.`;
    return figureOf(frame("against", `${metric.name} of both solvers in every sequence`, text, parts),
      "A dot for each sequence, in the colour of the better solver: above the line A, below it B." +
      (view.found.films.size ? " Those with a rim can be watched." : ""));
  }

  function point(view, row, across, up) {
    const films = view.found.films.has(row.sequence);
    const colour = row.difference === 0 ? "" : " c" + view.colours[row.difference < 0 ? view.a : view.b];
    const most = vbbench.figures.decimals([row.a, row.b]), show = (value) => vbbench.figures.figure(value, most);
    const tip = `Sequence ${row.sequence}: A ${show(row.a)}, B ${show(row.b)} ${view.metric.unit}${films ? "; click to watch" : ""}`;
    const dot = draw("circle", { class: "seq" + colour + (films ? " film" : ""), cx: across.toFixed(1), cy: up.toFixed(1),
      r: films ? 5 : 4, "data-tip": tip });
    if (films) dot.addEventListener("click", () => { location.hash = vbbench.comparison.address(view, row.sequence); });
    return dot;
  }

  /** Every sequence's A − B as a bar, the smallest left. */
  function inOrder(view) {
    const { rows, metric } = view;
    const sorted = [...rows].sort((one, two) => one.difference - two.difference);
    const values = sorted.map((row) => row.difference);
    const y = { ...axis([...values, 0], HEIGHT - BOTTOM, TOP) };
    const step = (WIDTH - RIGHT - LEFT) / Math.max(sorted.length, 1), zero = y.place(0);
    const bar = (row, n) => {
      const end = y.place(row.difference), better = row.difference < 0 ? view.a : view.b;
      return draw("rect", { class: "seq c" + view.colours[better], x: (LEFT + n * step).toFixed(2), y: Math.min(zero, end).toFixed(1),
        width: Math.max(step - (step > 4 ? 1 : 0), 0.6).toFixed(2), height: Math.abs(end - zero).toFixed(1) });
    };
    const grid = y.ticks.flatMap((value) => [
      rule(LEFT, y.place(value), WIDTH - RIGHT, y.place(value), value === 0 ? "even solid" : "grid"),
      words(LEFT - 8, y.place(value) + 4, short(value).replace("-", "−"), "tick", "end"),
    ]);
    const won = values.filter((value) => value < 0).length, lost = values.filter((value) => value > 0).length;
    const parts = [...grid, ...sorted.map(bar), words(0, 14, `${metric.name} of A − B, ${metric.unit}`, "axis-name"),
      words(LEFT, HEIGHT - BOTTOM + 22, `A is better in ${won}`, "tick"),
      ...(won + lost < rows.length ? [words((LEFT + WIDTH - RIGHT) / 2, HEIGHT - BOTTOM + 22,
        `alike in ${rows.length - won - lost}`, "tick", "middle")] : []),
      words(WIDTH - RIGHT, HEIGHT - BOTTOM + 22, `B is better in ${lost}`, "tick", "end")];
    const text = `${won} sequences in which A is better, ${lost} in which B is.`;
    return figureOf(frame("in-order", `${metric.name} of A − B in every sequence`, text, parts),
      "Every sequence's difference in order, in the colour of the better solver.");
  }

  vbbench.pairCharts = (view) => (view.rows.length ? [against(view), inOrder(view)] : []);
})();
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
