/* One player on the page: what is chosen, what is loaded, and the drawing of it. */
"use strict";
(function (parts) {
  const MOST = 3;
  const AT_FIRST = 2; // solvers, where the address names none
  const FLAGS = { follow: false, trails: true, errors: true, unboxed: true, ids: false, smooth: true, loop: false };
  const NONE = "–";

  /** A figure with two or three digits that matter. */
  function short(value) {
    if (!Number.isFinite(value)) return NONE;
    return value.toFixed(value >= 100 ? 0 : value >= 10 ? 1 : value >= 1 ? 2 : 3);
  }

  class Session {
    constructor(element, { board, state, onState }) {
      this.ui = parts.build(element);
      this.onState = onState || (() => {});
      this.views = { ego: new parts.EgoView(this.ui.ego), map: new parts.MapView(this.ui.map), strip: new parts.Strip(this.ui.strip) };
      const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
      Object.assign(this, { at: 0, playing: false, speed: 1, order: "worst", metric: "dx", pinned: -1, hovered: -1 });
      this.flags = { ...FLAGS, smooth: !calm };
      this.tick = this.tick.bind(this);
      this.isGiven = (t, k) => this.board.given !== "origin" && this.clip.observed[t * this.clip.K + k] && (t < parts.START || (this.board.given === "arrivals" && this.clip.given[t * this.clip.K + k]));
      this.isAlarm = (t, k) => parts.isFalseAlarm(this, t * this.clip.K + k);
      parts.connect(this);
      this.open(board, state || {});
    }

    /** Show a board, { key: "SPLIT/PROTOCOL-TIER", solvers: [{ name, colour }] }, at the state that an address gives. */
    async open(board, state) {
      const [split, name] = board.key.split("/"), turn = (this.turn = (this.turn || 0) + 1);
      try {
        const index = await parts.load(split).catch(() => null);
        if (turn !== this.turn) return;
        if (!index?.boards[name]) throw new Error(`No sequences of ${split}, ${name}, came with this page.`);
        const colours = new Map(board.solvers.map((solver) => [solver.name, solver.colour]));
        Object.assign(this, { index, name, colours, board: index.boards[name] });
        this.choose(state);
        await this.show(state.frame);
      } catch (error) {
        if (turn === this.turn) this.refuse(error);
      }
    }

    /** Take sequence and solvers from a state, or what is worth seeing first, and say what of it there is not. */
    choose(state) {
      const { index, board, colours } = this, names = Object.keys(board.solvers);
      this.solvers = names.map((name) => ({
        name, number: colours.get(name), shape: parts.SHAPES[(colours.get(name) - 1) % parts.SHAPES.length],
      }));
      const wanted = typeof state.solvers === "string" ? state.solvers.split(",") : state.solvers || [];
      const known = names.filter((name) => wanted.includes(name)).slice(0, MOST);
      const mean = (name) => board.solvers[name].dx.reduce((sum, value) => sum + Math.min(value ?? 0, board.caps.dx), 0);
      const best = [...names].sort((a, b) => mean(a) - mean(b)).slice(0, AT_FIRST);
      this.chosen = known.length ? known : names.filter((name) => best.includes(name));
      const number = Number(state.sequence ?? NaN);
      this.sequence = index.sequences.includes(number) ? number : this.sorted()[0];
      this.metric = Object.values(board.solvers).some(({ dx }) => dx.some((value) => value !== null)) ? "dx" : "dt";
      this.ui.metric.value = this.metric;
      parts.tellGone(this, state.sequence, wanted.filter((name) => name && !names.includes(name)));
      parts.listBoards(this);
      parts.listSequences(this);
    }

    /** Numbers of the sequences in the order that is chosen, by the mean Δx of the chosen solvers. */
    sorted() {
      const { index, board, order } = this;
      if (order === "number") return [...index.sequences];
      const sign = order === "worst" ? -1 : 1;
      return [...index.sequences].sort((a, b) => sign * (this.errorOf(a) - this.errorOf(b)) || a - b);
    }

    errorOf(sequence) {
      const place = this.index.sequences.indexOf(sequence), values = this.chosen.map((name) => this.board.solvers[name].dx[place] ?? 0);
      return values.reduce((sum, value) => sum + value, 0) / Math.max(1, values.length);
    }

    /** Load what is chosen, and go to a frame of it. */
    async show(frame) {
      const turn = (this.turn += 1), { index, name, board, sequence } = this;
      this.wanted = frame; // until it is loaded; the slider may want another by then
      try {
        const folder = `${index.split}/${board.tier}/${sequence}`;
        const clip = this.clip && this.folder === folder ? this.clip : await parts.decodeClip(await parts.load(folder));
        const scored = parts.scoredPositions(clip, board.given);
        const estimates = await Promise.all(this.chosen.map(async (solver) =>
          parts.addErrors(await parts.decodeEstimate(await parts.load(`${index.split}/${name}/${sequence}/${solver}`), clip), clip, scored)));
        if (turn === this.turn) this.begin(folder, clip, estimates);
      } catch (error) {
        if (turn === this.turn) this.refuse(error);
      }
    }

    begin(folder, clip, estimates) {
      const { ui, views, index, sequence } = this, fresh = clip !== this.clip;
      ui.note.hidden = true;
      ui.body.hidden = false;
      Object.assign(this, { folder, clip, estimates, moment: new parts.Moment(clip, estimates) });
      if (fresh) {
        const count = index.pictures[sequence] || 0, base = `data/player/pictures/${encodeURIComponent(index.split)}/${sequence}`;
        views.ego.start(clip, count ? new parts.Pictures(base, count, () => this.ask()) : null);
        views.map.start(clip);
        this.pinned = this.hovered = -1;
        parts.listPeople(this);
      }
      ui.scrub.max = clip.T - 1;
      if (fresh) this.others = null;
      if (this.others) this.moment.others = new parts.Others(clip, this.others);
      this.recolour();
      this.go(Number(this.wanted ?? this.moments[0]) || 0);
      this.wanted = null;
      this.moment.go(this.at, false, false);
      if (fresh) views.ego.turnTo(this.moment);
      if (fresh && clip.unboxed) this.findOthers(folder, clip);
    }

    /** People without a box come when all else is on the screen. */
    async findOthers(folder, clip) {
      const found = await parts.load(`${folder}/unboxed`).then((value) => parts.decodeOthers(value, clip)).catch(() => null);
      if (!found || this.clip !== clip) return;
      this.others = found;
      this.moment.others = new parts.Others(clip, found);
      this.ask();
    }

    recolour() {
      if (!this.clip) return;
      this.theme = parts.readTheme(this.clip.colours, this.index.palette);
      for (const solver of this.solvers) Object.assign(solver, { colour: this.theme.solver(solver.number), stamp: null });
      this.drawn = this.solvers.filter((solver) => this.chosen.includes(solver.name));
      parts.solverRows(this.ui, this.solvers, this.chosen, (name, on) => this.toggle(name, on));
      this.curves();
      this.last = -1;
      this.ask();
    }

    curves() {
      const { views, drawn, estimates, metric, clip, theme } = this;
      const values = estimates.map((estimate) => estimate[metric]), given = new Uint16Array(clip.T);
      for (let i = 0; i < clip.observed.length; i++) if (this.isGiven(Math.floor(i / clip.K), i % clip.K)) given[Math.floor(i / clip.K)] += 1;
      this.moments = parts.moments(values, this.board.caps[metric], clip.dt);
      views.strip.show(drawn.map(({ colour }, n) => ({ colour, values: values[n] })), given, this.moments, theme);
      this.ui.pair.textContent = parts.tellPair(drawn, values);
      this.ui.button("telling").disabled = !this.moments.length;
    }

    toggle(name, on) {
      const rest = this.chosen.filter((other) => other !== name);
      const wanted = on && rest.length < MOST ? [...rest, name] : rest;
      this.chosen = Object.keys(this.board.solvers).filter((other) => wanted.includes(other));
      parts.listSequences(this);
      this.show(this.wanted ?? this.at).then(() => this.tell());
    }

    go(at) {
      this.at = Math.min(Math.max(at, 0), this.clip.T - 1);
      if (this.wanted !== null) this.wanted = this.at;
      this.ask();
    }

    play(on) {
      if (!this.clip) return;
      if (on && this.at >= this.clip.T - 1) this.at = 0;
      this.playing = on;
      this.before = 0;
      if (!on) { this.at = Math.round(this.at); this.tell(); }
      parts.showPlaying(this.ui, on);
      this.ask();
    }

    ask() {
      if (!this.waiting) this.waiting = requestAnimationFrame(this.tick);
    }

    tick(now) {
      this.waiting = 0;
      if (!this.clip || !this.ui.root.isConnected) return;
      if (this.playing) this.advance(now);
      this.draw();
      if (this.playing) this.ask();
    }

    advance(now) {
      const end = this.clip.T - 1, passed = this.before ? Math.min(now - this.before, 250) / 1000 : 0;
      this.before = now;
      this.at += (passed * this.speed) / this.clip.dt;
      if (this.at < end) return;
      if (this.flags.loop && end > 0) this.at %= end;
      else { this.at = end; this.play(false); }
    }

    draw() {
      const { moment, views, flags, theme, drawn } = this;
      moment.go(this.at, flags.smooth && this.playing, views.ego.pictures);
      const options = this.options || (this.options = { isGiven: this.isGiven, isAlarm: this.isAlarm });
      Object.assign(options, flags);
      options.selected = this.hovered >= 0 ? this.hovered : this.pinned;
      views.ego.draw(moment, theme, options);
      views.map.draw(moment, drawn, theme, options);
      views.strip.draw(this.at);
      if (moment.frame !== this.last || options.selected !== this.lastPerson || !this.playing) this.read(options.selected);
    }

    /** Write down the figures of the frame. */
    read(person) {
      const { ui, moment, clip, estimates, drawn, solvers } = this, t = moment.frame;
      this.last = t;
      this.lastPerson = person;
      ui.scrub.value = t;
      ui.scrub.setAttribute("aria-valuetext", `frame ${t} of ${clip.T - 1}`);
      ui.clock.textContent = `${t} / ${clip.T - 1} · ${(t * clip.dt).toFixed(1)} s`;
      const place = this.index.sequences.indexOf(this.sequence);
      for (const solver of solvers) {
        const estimate = estimates[drawn.indexOf(solver)];
        solver.cells[0].textContent = estimate ? short(estimate.dx[t]) : "";
        solver.cells[1].textContent = estimate ? short(estimate.dt[t]) : "";
        solver.cells[2].textContent = short(this.board.solvers[solver.name].dx[place] ?? NaN);
      }
      ui.personText.textContent = person >= 0 ? parts.tellPerson(this, person) : "Point at somebody, or choose.";
      parts.showBoxes(this);
      if (!this.playing) parts.tellFrame(this);
    }

    state() {
      return { sequence: this.sequence, frame: Math.round(this.at), solvers: [...this.chosen] };
    }

    /** Tell the page what is shown, for its address. */
    tell() {
      clearTimeout(this.telling);
      this.onState(this.state());
    }

    tellSoon() {
      clearTimeout(this.telling);
      this.telling = setTimeout(() => this.tell(), 250);
    }

    refuse(error) {
      this.playing = false;
      this.clip = null;
      this.ui.body.hidden = true;
      this.ui.note.hidden = false;
      this.ui.note.textContent = error.message;
    }

    close() {
      this.turn += 1;
      this.playing = false;
      cancelAnimationFrame(this.waiting);
      clearTimeout(this.telling);
      for (const stop of this.stops) stop();
      this.ui.root.remove();
    }
  }

  Object.assign(parts, { Session, short });
})(vbbench.player.parts);
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
