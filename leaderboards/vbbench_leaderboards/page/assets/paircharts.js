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
