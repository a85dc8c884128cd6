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
