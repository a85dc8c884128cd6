/* What stands upon the map: ids, the chosen person, the scale bar; and finding the person under the pointer. */
"use strict";
(function (parts) {
  const REACH = 14; // CSS px

  Object.assign(parts.MapView.prototype, {
    sx(x) { return this.ox + x * this.k; },
    sy(y) { return this.oy - y * this.k; },

    /** Place of a point of the canvas (CSS px) in m. */
    place(x, y) {
      const { ratio } = this.canvas;
      return [(x * ratio - this.ox) / this.k, (this.oy - y * ratio) / this.k];
    },

    /** The person, true or estimated, nearest to a point of the canvas (CSS px), or -1. */
    pick(moment, x, y) {
      const { ratio } = this.canvas;
      let best = REACH * ratio, found = -1;
      for (const room of [moment.truth, ...moment.estimates]) {
        for (let n = 0; n < this.clip.K; n++) {
          const far = Math.hypot(this.sx(room.px[n]) - x * ratio, this.sy(room.py[n]) - y * ratio);
          if (far < best) { best = far; found = n; }
        }
      }
      const { others } = moment;
      for (let n = 0; others && n < others.N; n++) {
        const far = others.reason(n) ? Math.hypot(this.sx(others.px[n]) - x * ratio, this.sy(others.py[n]) - y * ratio) : best;
        if (far < best) { best = far; found = n; }
      }
      return found;
    },

    drawIds(moment, theme) {
      const { context, canvas, clip } = this, { ratio } = canvas, { px, py } = moment.truth;
      context.font = `${10 * ratio}px ${parts.FONT}`;
      context.textAlign = "left";
      context.textBaseline = "middle";
      for (let n = 0; n < clip.K; n++) {
        if (px[n] !== px[n] || !moment.isShown(n)) continue;
        parts.label(context, clip.tracks[n], this.sx(px[n]) + 7 * ratio, this.sy(py[n]) - 7 * ratio, theme.ink, theme.paper);
      }
    },

    drawSelected(moment, theme, n) {
      const { context, canvas, clip } = this, { ratio } = canvas, [px, py] = moment.placeOf(n);
      if (px !== px) return;
      const x = this.sx(px), y = this.sy(py);
      context.beginPath();
      context.arc(x, y, Math.max(0.42 * this.k, 10 * ratio), 0, 2 * Math.PI);
      context.lineWidth = 2.5 * ratio;
      context.strokeStyle = theme.accent;
      context.stroke();
      context.font = `600 ${12 * ratio}px ${parts.FONT}`;
      context.textAlign = "left";
      context.textBaseline = "middle";
      parts.label(context, n < clip.K ? `person ${clip.tracks[n]}` : "no box", x + 14 * ratio, y - 12 * ratio, theme.ink, theme.paper);
    },

    drawScale(theme) {
      const { context, canvas, k, step } = this, { ratio } = canvas, long = step * k;
      const x = canvas.width - long - 12 * ratio, y = canvas.height - 12 * ratio;
      context.strokeStyle = theme.ink;
      context.lineWidth = 1.5 * ratio;
      context.beginPath();
      context.moveTo(x, y - 5 * ratio); context.lineTo(x, y);
      context.lineTo(x + long, y); context.lineTo(x + long, y - 5 * ratio);
      context.stroke();
      context.font = `${11 * ratio}px ${parts.FONT}`;
      context.textAlign = "center";
      context.textBaseline = "bottom";
      parts.label(context, `${step} m`, x + long / 2, y - 3 * ratio, theme.ink, theme.paper);
    },
  });
})(vbbench.player.parts);
/* The strip under the scrubber: error over time, a line a solver; what is given, and the moments that tell most. */
"use strict";
(function (parts) {
  const LEFT = 34, RIGHT = 6, TOP = 14, BOTTOM = 19, TICK = 4; // CSS px
  const STEEP = 8; // a solver that is so many times worse than another is cut off at the top

  class Strip {
    constructor(canvas) {
      this.canvas = canvas;
      this.context = canvas.getContext("2d");
      this.still = document.createElement("canvas"); // all but the cursor
    }

    /** Curves are { colour, values [T] }, given [T] counts of given positions, moments are frames; drawn until a change. */
    show(curves, given, moments, theme) {
      Object.assign(this, { curves, given, moments, frames: given.length, theme, stale: true });
    }

    draw(at) {
      const { canvas, context } = this;
      if (parts.fit(canvas) || this.stale) this.paint();
      const { ratio } = canvas;
      context.setTransform(1, 0, 0, 1, 0, 0);
      context.clearRect(0, 0, canvas.width, canvas.height);
      context.drawImage(this.still, 0, 0);
      context.fillStyle = this.theme.accent;
      context.fillRect(this.x(at) - ratio, 0, 2 * ratio, canvas.height - BOTTOM * ratio);
      for (const { colour, values } of this.curves) {
        const value = values[Math.floor(at)];
        if (value !== value) continue;
        context.beginPath();
        context.arc(this.x(Math.floor(at)), this.y(value), 3 * ratio, 0, 2 * Math.PI);
        context.fillStyle = colour;
        context.fill();
      }
    }

    x(at) {
      const { ratio, width } = this.canvas;
      return LEFT * ratio + (at / Math.max(1, this.frames - 1)) * (width - (LEFT + RIGHT) * ratio);
    }

    y(value) {
      const { ratio, height } = this.canvas;
      return height - BOTTOM * ratio - (Math.min(value, 1.05 * this.top) / this.top) * (height - (TOP + BOTTOM) * ratio);
    }

    /** Frame at a column of the canvas (CSS px). */
    frameAt(column) {
      const share = (column - LEFT) / (this.canvas.clientWidth - LEFT - RIGHT);
      return Math.round(Math.min(Math.max(share, 0), 1) * (this.frames - 1));
    }

    paint() {
      const { canvas, still, theme, curves } = this, { ratio } = canvas;
      Object.assign(still, { width: canvas.width, height: canvas.height });
      const context = still.getContext("2d");
      const largest = curves.map(({ values }) => values.reduce((most, v) => (v > most ? v : most), 0)).filter((most) => most > 0);
      const least = Math.min(...largest), whole = Math.max(...largest, 1e-3);
      this.top = ceiling(whole > STEEP * least ? Math.max(2 * least, 1e-3) : whole);
      this.paintGiven(context, ratio);
      context.fillStyle = theme.line;
      for (const share of [0, 0.5, 1]) {
        context.fillRect(LEFT * ratio, Math.round(this.y(share * this.top)), canvas.width - (LEFT + RIGHT) * ratio, 1);
      }
      this.letter(context, ratio);
      if (curves.length === 2) this.paintBetween(context);
      for (const { colour, values } of curves) this.curve(context, colour, values, ratio);
      if (whole > 1.05 * this.top) this.paintCut(context, whole, ratio);
      this.paintMoments(context, ratio);
      this.stale = false;
    }

    /** A band where everything is given, and a tick under every frame in which somebody's position is. */
    paintGiven(context, ratio) {
      const { theme, given, frames } = this, low = this.y(0);
      context.fillStyle = theme.ink;
      context.globalAlpha = 0.07;
      context.fillRect(this.x(0), 0, this.x(Math.min(parts.START, frames) - 0.5) - this.x(0), low);
      context.globalAlpha = 0.55;
      const wide = Math.max(ratio, Math.min(3 * ratio, this.x(1) - this.x(0) - ratio));
      for (let t = 0; t < frames; t++) if (given[t]) context.fillRect(this.x(t) - wide / 2, low + ratio, wide, TICK * ratio);
      context.globalAlpha = 1;
    }

    /** The area between two lines, in the colour of the one with the larger error. */
    paintBetween(context) {
      const [first, second] = this.curves;
      context.globalAlpha = 0.16;
      for (let t = 1; t < this.frames; t++) {
        const [a, b, c, d] = [first.values[t - 1], first.values[t], second.values[t], second.values[t - 1]];
        if (!(a + b + c + d < Infinity)) continue;
        context.fillStyle = a + b > c + d ? first.colour : second.colour;
        context.beginPath();
        context.moveTo(this.x(t - 1), this.y(a)); context.lineTo(this.x(t), this.y(b));
        context.lineTo(this.x(t), this.y(c)); context.lineTo(this.x(t - 1), this.y(d));
        context.fill();
      }
      context.globalAlpha = 1;
    }

    /** Say how far a line goes that leaves the strip at its top. */
    paintCut(context, whole, ratio) {
      context.font = `${10 * ratio}px ${parts.FONT}`;
      context.textAlign = "right";
      context.textBaseline = "middle";
      const text = `↑ up to ${parts.short(whole)}`, x = this.canvas.width - (RIGHT + 2) * ratio;
      parts.label(context, text, x, this.y(this.top) + 8 * ratio, this.theme.ink, this.theme.paper);
    }

    paintMoments(context, ratio) {
      context.fillStyle = this.theme.accent;
      this.moments.forEach((t, n) => {
        const x = this.x(t), size = (n ? 3.5 : 5) * ratio;
        context.beginPath();
        context.moveTo(x - size, ratio); context.lineTo(x + size, ratio); context.lineTo(x, ratio + 1.5 * size);
        context.globalAlpha = n ? 0.6 : 1;
        context.fill();
      });
      context.globalAlpha = 1;
    }

    letter(context, ratio) {
      context.fillStyle = this.theme.faint;
      context.font = `${10 * ratio}px ${parts.FONT}`;
      context.textAlign = "right";
      context.textBaseline = "middle";
      for (const share of [0, 0.5, 1]) {
        context.fillText(String(+(share * this.top).toPrecision(3)), (LEFT - 5) * ratio, this.y(share * this.top));
      }
      context.textAlign = "center";
      context.textBaseline = "bottom";
      const every = [1, 2, 5, 10, 20, 50, 100, 200, 500].find((n) => this.frames / n <= 10) || 1000;
      for (let t = 0; t < this.frames; t += every) context.fillText(t, this.x(t), this.canvas.height);
    }

    curve(context, colour, values, ratio) {
      context.beginPath();
      let drawn = false;
      values.forEach((value, t) => {
        if (value === value) context[drawn ? "lineTo" : "moveTo"](this.x(t), this.y(value));
        drawn = value === value;
      });
      context.lineWidth = 1.6 * ratio;
      context.strokeStyle = colour;
      context.stroke();
    }
  }

  /** The next round number. */
  function ceiling(value) {
    const decade = 10 ** Math.floor(Math.log10(value));
    return decade * [1, 1.5, 2, 3, 4, 6, 8, 10].find((step) => step * decade >= value * 0.999);
  }

  Object.assign(parts, { Strip });
})(vbbench.player.parts);
/* Pointer, wheel and touch on the views. */
"use strict";
(function (parts) {
  const CLICK = 5; // CSS px that a click may wander

  /** Drag to pan, wheel or pinch to zoom, hover and click to find a person. Handlers: pan, zoom, hover, click. */
  function onMap(canvas, handlers) {
    const held = new Map();
    let travelled = 0;
    const at = (event) => {
      const box = canvas.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    };
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      const lines = event.deltaMode === 1 ? 16 : 1;
      handlers.zoom(Math.exp(-0.0016 * lines * event.deltaY), ...at(event));
    }, { passive: false });
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      held.set(event.pointerId, at(event));
      if (held.size === 1) travelled = 0;
    });
    canvas.addEventListener("pointermove", (event) => {
      const now = at(event), before = held.get(event.pointerId);
      if (!before) return handlers.hover(...now);
      const others = [...held].filter(([id]) => id !== event.pointerId).map(([, place]) => place);
      held.set(event.pointerId, now);
      travelled += Math.hypot(now[0] - before[0], now[1] - before[1]);
      if (others.length) pinch(before, now, others[0]);
      else if (travelled > CLICK) handlers.pan(now[0] - before[0], now[1] - before[1]);
    });
    const pinch = (before, now, other) => {
      const apart = ([x, y]) => Math.hypot(x - other[0], y - other[1]) || 1;
      handlers.pan((now[0] - before[0]) / 2, (now[1] - before[1]) / 2);
      handlers.zoom(apart(now) / apart(before), (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
    };
    const release = (event) => {
      const was = held.delete(event.pointerId);
      if (was && event.type === "pointerup" && travelled <= CLICK) handlers.click(...at(event));
    };
    canvas.addEventListener("pointerup", release);
    canvas.addEventListener("pointercancel", release);
    canvas.addEventListener("pointerleave", () => handlers.hover(-1, -1));
  }

  /** Hover and click on a view that does not move. */
  function onView(canvas, handlers) {
    canvas.addEventListener("pointermove", (event) => handlers.hover(event.offsetX, event.offsetY));
    canvas.addEventListener("pointerleave", () => handlers.hover(-1, -1));
    canvas.addEventListener("click", (event) => handlers.click(event.offsetX, event.offsetY));
  }

  /** Click or drag along the strip. */
  function onStrip(canvas, jump) {
    const go = (event) => { if (event.buttons) jump(event.offsetX); };
    canvas.addEventListener("pointerdown", (event) => { canvas.setPointerCapture(event.pointerId); go(event); });
    canvas.addEventListener("pointermove", go);
  }

  Object.assign(parts, { onMap, onView, onStrip });
})(vbbench.player.parts);
/* The player's controls: native buttons, selects, check boxes and sliders, and what they are called. */
"use strict";
(function (parts) {
  const ICONS = {
    start: "M5 4v16M20 4 9 12l11 8z", back: "M16 5 7 12l9 7z", play: "M7 4l13 8-13 8z", pause: "M7 4v16M17 4v16",
    on: "M8 5l9 7-9 7z", fit: "M4 9V4h5M15 4h5v5M20 15v5h-5M9 20H4v-5", all: "M9 4v5H4M15 9h5M15 4v5M20 15h-5v5M9 20v-5H4M4 4l5 5M20 4l-5 5M20 20l-5-5M4 20l5-5", end: "M19 4v16M4 4l11 8-11 8z", link: "M9 15l6-6M10 6l2-2a4 4 0 0 1 6 6l-2 2M14 18l-2 2a4 4 0 0 1-6-6l2-2",
  };
  const icon = (name) => `<svg viewBox="0 0 24 24" aria-hidden="true"><path d="${ICONS[name]}"/></svg>`;
  const button = (name, label, content) => `<button type="button" data-do="${name}" title="${label}" aria-label="${label}">${content}</button>`;
  const check = (name, label, key) => `<label class="player-check"><input type="checkbox" data-flag="${name}"> ${label} <kbd>${key}</kbd></label>`;
  const KEYS = [
    ["Space", "play or pause"], ["← →", "a frame back or on"], ["Home End", "first or last frame"],
    ["w", "the moments that tell most"], ["+ −", "zoom"], ["Shift + arrows", "move the map"], ["0", "see where everybody truly is"],
    ["a", "see all estimates of the frame"], ["f", "follow the camera"], ["b", "people without a box"],
    ["l", "loop"], ["t", "trails"], ["e", "error lines"], ["i", "ids"], ["m", "smooth motion between frames"],
    ["[ ]", "previous or next person"], ["?", "this help"],
  ];

  const TEMPLATE = `
    <div class="player-head">
      <label class="player-which"><span>Sequence</span> <select data-sequence></select></label>
      ${button("earlier", "Previous sequence in this order", icon("back"))}${button("later", "Next sequence in this order", icon("on"))}
      <label><span>Order</span> <select data-order>
        <option value="worst">worst first</option><option value="best">best first</option>
        <option value="number">by number</option></select></label>
      <label><span>Board</span> <select data-board></select></label>
      <span class="player-facts" data-facts></span>
      <span class="player-end">${button("link", "Copy a link to this frame", icon("link") + "<span>Copy link</span>")}${button("help", "Keys", "?")}</span>
    </div>
    <p class="player-gone" data-gone role="status" hidden></p>
    <p class="player-note" data-note role="status" hidden></p>
    <div class="player-body" data-body>
      <div class="player-sight" data-sight role="group" aria-label="What the observer sees" tabindex="0">
        <canvas class="player-ego" data-ego role="img"></canvas></div>
      <p class="player-boxes" data-boxes-line><span data-boxes><i class="player-box"></i> <span></span></span> <span data-alarms><i class="player-box player-alarm"></i> <span></span></span>
        <span data-without><i class="player-box player-without"></i> <span></span></span></p>
      <div class="player-ground">
        <canvas class="player-map" data-map role="img" tabindex="0"></canvas>
        <div class="player-zoom">${button("in", "Zoom in", "+")}${button("out", "Zoom out", "−")}${button("fit", "See where everybody truly is", icon("fit"))}${button("all", "See all estimates of this frame, however far off", icon("all"))}</div>
        <p class="player-legend"><b><span class="player-true"></span> true place</b> <b><span class="player-hollow"></span> without a box</b> <b><span class="player-given"></span> given</b> <b><span class="player-cone"></span> camera</b></p>
      </div>
      <div class="player-side">
        <table class="player-solvers">
          <caption>Solvers, up to three</caption>
          <thead><tr><th scope="col">this frame, m</th><th scope="col" title="Mean error of the people's positions">Δx</th>
            <th scope="col" title="Error of the camera's position">Δt</th><th scope="col" title="Mean Δx of the whole sequence">mean Δx</th></tr></thead>
          <tbody data-solvers></tbody>
        </table>
        <div class="player-person"><label>Person <select data-person><option value="-1">nobody</option></select></label>
          <p data-person-text></p></div>
        <div class="player-flags">
          ${check("follow", "Follow the camera", "f")}${check("trails", "Trails", "t")}${check("errors", "Error lines", "e")}${check("unboxed", "No box", "b")}
          ${check("ids", "Ids", "i")}${check("smooth", "Smooth", "m")}${check("loop", "Loop", "l")}
        </div>
      </div>
      <div class="player-transport">
        <span class="player-buttons">${button("start", "First frame", icon("start"))}${button("previous", "One frame back", icon("back"))}${button("play", "Play", icon("play"))}${button("next", "One frame on", icon("on"))}${button("end", "Last frame", icon("end"))}</span>
        <input type="range" min="0" step="1" data-scrub aria-label="Frame">
        <output class="player-clock" data-clock></output>
        <label>Speed <select data-speed><option value="0.25">¼×</option><option value="0.5">½×</option>
          <option value="1" selected>1×</option><option value="2">2×</option><option value="4">4×</option></select></label>
      </div>
      <div class="player-over-time">
        <label class="player-metric">Over time <select data-metric><option value="dx">Δx, people, m</option>
          <option value="dt">Δt, camera, m</option><option value="dr">Δr, camera, rad</option></select></label>
        ${button("telling", "Go to the moment that tells most, and on to the next", `<span class="player-tip">▼</span> Moments`)}
        <span class="player-key">▼ tells most; grey and ticks: given</span>
        <span class="player-pair" data-pair></span>
        <canvas class="player-strip" data-strip role="img" aria-label="Error over time, a line a solver"></canvas>
      </div>
      <p class="player-said" data-said aria-live="polite"></p>
    </div>
    <dialog class="player-help" data-help aria-label="Keys"><h3>Keys</h3>
      <dl>${KEYS.map(([key, text]) => `<dt><kbd>${key}</kbd></dt><dd>${text}</dd>`).join("")}</dl>
      <p>Drag the map to move it; wheel or pinch to zoom; point at a person to see its errors, click to keep it.</p>
      <form method="dialog"><button>Close</button></form></dialog>`;

  /** Build the player into an element; the parts by the names of their data attributes. */
  function build(element) {
    element.innerHTML = `<section class="player" aria-label="Sequence player">${TEMPLATE}</section>`;
    const root = element.firstElementChild, found = { root };
    for (const name of ["sight", "board", "sequence", "order", "facts", "note", "body", "ego", "map", "solvers", "person", "person-text",
      "scrub", "clock", "speed", "metric", "strip", "said", "help", "gone", "pair"]) {
      found[name.replace("-t", "T")] = root.querySelector(`[data-${name}]`);
    }
    found.boxes = root.querySelector("[data-boxes-line]");
    found.button = (name) => root.querySelector(`[data-do="${name}"]`);
    found.flag = (name) => root.querySelector(`[data-flag="${name}"]`);
    return found;
  }

  function showPlaying(ui, playing) {
    const play = ui.button("play"), label = playing ? "Pause" : "Play";
    play.innerHTML = icon(playing ? "pause" : "play");
    play.title = label;
    play.setAttribute("aria-label", label);
  }

  /** A row a solver: its check box with the mark it has on the map, and cells for its errors. */
  function solverRows(ui, solvers, chosen, toggle) {
    const held = ui.solvers.contains(document.activeElement) ? document.activeElement.value : null;
    ui.solvers.replaceChildren(...solvers.map((solver) => {
      const row = document.createElement("tr"), head = document.createElement("th"), label = document.createElement("label");
      const box = Object.assign(document.createElement("input"), { type: "checkbox", value: solver.name, checked: chosen.includes(solver.name) });
      box.disabled = !box.checked && chosen.length >= 3;
      box.addEventListener("change", () => toggle(solver.name, box.checked));
      label.append(box, mark(solver), solver.name);
      head.scope = "row";
      head.append(label);
      row.append(head, ...["dx", "dt", "mean"].map(() => document.createElement("td")));
      solver.cells = row.querySelectorAll("td");
      return row;
    }));
    if (held !== null) ui.solvers.querySelector(`input[value="${CSS.escape(held)}"]`)?.focus();
  }

  function mark(solver) {
    const canvas = Object.assign(document.createElement("canvas"), { width: 32, height: 32, className: "player-mark" });
    const context = canvas.getContext("2d");
    parts.addShape(context, solver.shape, 16, 16, 10);
    context.lineWidth = 4;
    context.strokeStyle = solver.colour;
    context.stroke();
    canvas.setAttribute("aria-hidden", "true");
    return canvas;
  }

  function options(select, pairs, value) {
    select.replaceChildren(...pairs.map(([key, text]) => new Option(text, key)));
    select.value = value;
  }

  Object.assign(parts, { build, showPlaying, solverRows, options });
})(vbbench.player.parts);
/* What the player says in words: lists to choose from, a person's errors, the frame's, and what the views show. */
"use strict";
(function (parts) {
  const short = (value) => parts.short(value);

  /** The list of sequences, each with its people, frames and error. */
  function listSequences(s) {
    const { index } = s, text = (sequence) => {
      const place = index.sequences.indexOf(sequence);
      return `${sequence} · Δx ${short(s.errorOf(sequence))} m · ${index.people[place]} people · ${index.frames[place]} frames`;
    };
    parts.options(s.ui.sequence, s.sorted().map((sequence) => [sequence, text(sequence)]), s.sequence);
    const known = { relative: "; all as seen from the camera, Δx is Δx̃", poses: "; where people really are is not known" };
    s.ui.facts.textContent = `${index.sequences.length === 1 ? "1 sequence" : `${index.sequences.length} sequences`} of ${index.split}${index.sequences.length > 2 ? ", the best and the worst among them" : ""}${known[index.truth] || ""}`;
  }

  /** The boards on which this sequence can be played. */
  function listBoards(s) {
    const pairs = Object.keys(s.index.boards).map((name) => [name, name.replace(/-(?=[^-]*$)/, ", ")]);
    parts.options(s.ui.board, pairs, s.name);
  }

  function listPeople(s) {
    const people = Array.from(s.clip.tracks, (track, k) => [k, track]);
    parts.options(s.ui.person, [[-1, "nobody"], ...people], -1);
  }

  /** A person's distance and errors in this frame. */
  function tellPerson(s, k) {
    const { moment, clip, drawn, estimates } = s, i = moment.frame * clip.K + k, t = moment.frame;
    const reason = moment.others ? moment.others.reason(k) : 0, [px, py] = moment.placeOf(k), why = parts.REASONS[reason][1];
    const away = Math.hypot(px - moment.truth.x, py - moment.truth.y);
    if (k >= clip.K) return reason ? `Somebody, ${away.toFixed(1)} m away; ${why}.` : "Somebody who is not there in this frame.";
    if (s.isAlarm(t, k)) return `Box ${clip.tracks[k]} shows nobody: a false alarm, which is not scored.`;
    if (Number.isNaN(clip.px[i])) return `Person ${clip.tracks[k]} is not there in this frame.`;
    if (!clip.observed[i] && !reason) return `Person ${clip.tracks[k]} has another box in this frame: the track was lost.`;
    const errors = estimates.map((estimate, n) =>
      `${drawn[n].name} ${short(Math.hypot(estimate.px[i] - clip.px[i], estimate.py[i] - clip.py[i]))} m`);
    const state = s.isGiven(t, k) ? "; its position is given" : why && `; ${why}`;
    return `Person ${clip.tracks[k]}, ${away.toFixed(1)} m away${state}. Off by: ${errors.join(", ") || "no solver chosen"}.`;
  }

  /** Say the frame's errors, and describe both views, for those who hear the page. */
  function tellFrame(s) {
    const { ui, clip, moment, drawn, estimates } = s, t = moment.frame;
    let seen = 0;
    for (let k = 0; k < clip.K; k++) seen += clip.observed[t * clip.K + k];
    const errors = t < parts.START ? (s.board.given === "origin" ? "nothing is scored" : "everything is given") : !seen ? "nothing is scored" : estimates
      .map((estimate, n) => `${drawn[n].name}: people off by ${short(estimate.dx[t])} m, camera by ${short(estimate.dt[t])} m`).join("; ");
    const said = `Frame ${t} of ${clip.T - 1}, ${seen} people seen${errors && ": "}${errors}.`;
    if (ui.said.textContent !== said) ui.said.textContent = said;
    const camera = clip.picture.round ? "the panorama around the observer" : "the observer's picture";
    ui.ego.setAttribute("aria-label", `Boxes of ${seen} people in ${camera}.`);
    const outside = drawn.map(({ name }, n) => (s.views.map.outside?.[n]?.length ? ` Outside the map: ${name} ${s.views.map.outside[n].join(", ")}.` : ""));
    ui.map.setAttribute("aria-label", `Map from above: the observer, the people around, and the estimates of ${
      drawn.map(({ name }) => name).join(", ") || "no solver"}.${outside.join("")}`);
  }

  /** How many boxes there are, and why some people have none, each beside the mark that it has. */
  function showBoxes(s) {
    const said = parts.tellBoxes(s);
    for (const [name, text] of Object.entries(said)) {
      const place = s.ui.boxes.querySelector(`[data-${name}]`);
      if (place.lastChild.textContent !== text) place.lastChild.textContent = text;
      place.hidden = !text;
    }
  }

  /** Say what an address asks for that cannot be played here. */
  function tellGone(s, sequence, solvers) {
    const gone = [], asked = sequence !== undefined && String(sequence) !== String(s.sequence);
    if (asked) gone.push(`Sequence ${sequence} cannot be played here; this is sequence ${s.sequence}.`);
    if (solvers.length) gone.push(`There is no solver ${solvers.join(", ")} on this board.`);
    s.ui.gone.textContent = gone.join(" ");
    s.ui.gone.hidden = !gone.length;
  }

  Object.assign(parts, { listBoards, listSequences, listPeople, tellPerson, tellFrame, showBoxes, tellGone });
})(vbbench.player.parts);
