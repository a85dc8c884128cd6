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
