/* Controls and keys joined to the player, and how the page mounts it: vbbench.player.mount and unmount. */
"use strict";
(function (parts) {
  const ZOOM = 1.3, PAN = 60; // a press of a key
  const PLAIN = { " ": "play", ArrowLeft: "previous", ArrowRight: "next", Home: "start", End: "end" };
  const OTHER = { "+": "in", "=": "in", "-": "out", "−": "out", 0: "fit", a: "all", w: "telling", "?": "help" };
  const FLAG_KEYS = { f: "follow", l: "loop", t: "trails", e: "errors", b: "unboxed", i: "ids", m: "smooth" };
  const SHIFTS = { ArrowLeft: [PAN, 0], ArrowRight: [-PAN, 0], ArrowUp: [0, PAN], ArrowDown: [0, -PAN] };

  const actions = {
    play: (s) => s.play(!s.playing),
    previous: (s) => step(s, -1),
    next: (s) => step(s, 1),
    start: (s) => jump(s, 0),
    end: (s) => jump(s, s.clip.T - 1),
    in: (s) => zoom(s, ZOOM),
    out: (s) => zoom(s, 1 / ZOOM),
    fit: (s) => { s.views.map.fitTruth(); s.ask(); },
    all: (s) => { s.views.map.fitAll(s.moment); s.ask(); },
    telling: (s) => nextTelling(s),
    earlier: (s) => neighbour(s, -1),
    later: (s) => neighbour(s, 1),
    help: (s) => s.ui.help.showModal(),
    link: (s) => copyLink(s),
  };

  function jump(s, frame) {
    if (s.playing) s.play(false);
    s.go(frame);
    s.tellSoon();
  }

  /** To the moment that tells most; from one of them to the next. */
  function nextTelling(s) {
    const place = s.moments.indexOf(Math.round(s.at));
    if (s.moments.length) jump(s, s.moments[(place + 1) % s.moments.length]);
  }

  function step(s, by) { jump(s, Math.round(s.at) + by); }

  function zoom(s, factor) {
    s.views.map.zoom(factor, s.ui.map.clientWidth / 2, s.ui.map.clientHeight / 2);
    s.ask();
  }

  function pick(s, sequence) {
    if (s.playing) s.play(false);
    s.sequence = sequence;
    s.ui.sequence.value = sequence;
    s.ui.gone.hidden = true;
    s.show().then(() => s.tell());
  }

  function neighbour(s, by) {
    const order = s.sorted(), place = order.indexOf(s.sequence) + by;
    if (order[place] !== undefined) pick(s, order[place]);
  }

  /** Go to another board of the split, and stay in the sequence, at the frame, with the solvers. */
  function otherBoard(s, name) {
    const options = Object.fromEntries(Object.entries(s.state()).map(([key, value]) => [key, String(value)]));
    location.hash = vbbench.state.format({ board: `${s.index.split}/${name}`, play: true, options });
  }

  async function copyLink(s) {
    s.tell();
    const said = s.ui.button("link").querySelector("span");
    try {
      await navigator.clipboard.writeText(location.href);
      said.textContent = "Copied";
    } catch {
      said.textContent = "Copy the address above";
    }
    said.className = "said";
    setTimeout(() => Object.assign(said, { textContent: "Copy link", className: "" }), 2500);
  }

  function setFlag(s, name, on) {
    if (name === "follow" && on !== s.flags.follow) s.views.map.follow(on, s.moment.truth);
    s.flags[name] = on;
    s.ui.flag(name).checked = on;
    s.ask();
  }

  function person(s, k) {
    s.pinned = k;
    s.ui.person.value = k;
    s.last = -1;
    s.ask();
  }

  function connect(s) {
    const { ui } = s;
    ui.root.addEventListener("click", (event) => {
      const name = event.target.closest("[data-do]")?.dataset.do;
      if (name && (s.clip || name === "help")) actions[name](s);
    });
    ui.sequence.addEventListener("change", () => pick(s, Number(ui.sequence.value)));
    ui.board.addEventListener("change", () => otherBoard(s, ui.board.value));
    ui.order.addEventListener("change", () => { s.order = ui.order.value; parts.listSequences(s); });
    ui.scrub.addEventListener("input", () => jump(s, Number(ui.scrub.value)));
    ui.speed.value = s.speed;
    ui.speed.addEventListener("change", () => { s.speed = Number(ui.speed.value); });
    ui.metric.addEventListener("change", () => { s.metric = ui.metric.value; if (s.clip) { s.curves(); s.ask(); } });
    ui.person.addEventListener("change", () => person(s, Number(ui.person.value)));
    for (const name of Object.keys(s.flags)) {
      ui.flag(name).checked = s.flags[name];
      ui.flag(name).addEventListener("change", (event) => { if (s.clip) setFlag(s, name, event.target.checked); });
    }
    connectViews(s);
    const keys = (event) => onKey(s, event);
    document.addEventListener("keydown", keys);
    const sizes = new ResizeObserver(() => s.ask());
    for (const canvas of [ui.ego, ui.map, ui.strip]) sizes.observe(canvas);
    s.stops = [() => document.removeEventListener("keydown", keys), () => sizes.disconnect(), parts.onTheme(() => s.recolour())];
  }

  function connectViews(s) {
    const { map, ego, strip } = s.views;
    const hover = (view) => (x, y) => {
      const found = s.clip && x >= 0 ? view.pick(s.moment, x, y) : -1;
      if (found !== s.hovered) { s.hovered = found; s.ask(); }
    };
    const click = (view) => (x, y) => person(s, view.pick(s.moment, x, y));
    parts.onView(s.ui.ego, { hover: hover(ego), click: click(ego) });
    parts.onMap(s.ui.map, {
      hover: hover(map), click: click(map),
      zoom: (factor, x, y) => { map.zoom(factor, x, y); s.ask(); },
      pan: (dx, dy) => { map.pan(dx, dy); s.ask(); },
    });
    parts.onStrip(s.ui.strip, (x) => jump(s, strip.frameAt(x)));
  }

  function onKey(s, event) {
    if (!s.clip || s.ui.help.open || event.ctrlKey || event.metaKey || event.altKey) return;
    const { key, target } = event, busy = target.closest?.("input, select, textarea, button, a, summary");
    if (busy && (key in PLAIN || target.matches("select, textarea, input:not([type=checkbox], [type=range])"))) return;
    if (event.shiftKey && key in SHIFTS) { s.views.map.pan(...SHIFTS[key]); s.ask(); }
    else if (key in PLAIN) actions[PLAIN[key]](s);
    else if (key in OTHER) actions[OTHER[key]](s);
    else if (key in FLAG_KEYS) setFlag(s, FLAG_KEYS[key], !s.flags[FLAG_KEYS[key]]);
    else if (key === "[" || key === "]") person(s, nextPerson(s, key === "]" ? 1 : -1));
    else return;
    event.preventDefault();
  }

  /** The next person who is there in this frame. */
  function nextPerson(s, by) {
    const { K } = s.clip, { px } = s.moment.truth;
    for (let n = 1, k = s.pinned; n <= K; n++) {
      k = (k + by + K) % K;
      if (px[k] === px[k]) return k;
    }
    return -1;
  }

  let session = null;

  /** Show the player in an element: { board, state: { sequence, frame, solvers }, onState(state) }. */
  vbbench.player.mount = (element, wanted) => {
    vbbench.player.unmount();
    session = new parts.Session(element, wanted);
    vbbench.player.session = session;
  };

  vbbench.player.unmount = () => {
    if (session) session.close();
    session = vbbench.player.session = null;
  };

  Object.assign(parts, { connect });
})(vbbench.player.parts);
