/* The player of sequences: what the observer sees, the map from above, and the errors over time. */
"use strict";
(function () {
  const START = 2; // frames 0 and 1 are given under every protocol
  const METRE = 1e-3, PIXEL = 0.1, RADIAN = 1e-4; // the quanta of site/player.py
  const FONT = "system-ui, sans-serif", { make } = vbbench;
  const count = (number, one, more = `${one}s`) => `${number} ${number === 1 ? one : more}`;
  const wrap = (angle) => angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI));

  /** A figure with two or three digits that matter. */
  function short(value) {
    if (!Number.isFinite(value)) return "–";
    return value.toFixed(value >= 100 ? 0 : value >= 10 ? 1 : value >= 1 ? 2 : 3);
  }

  /* Data: the decoding of what site/player.py wrote. */

  async function load(name) {
    const value = await vbbench.load(`player/${name}`);
    if (value === undefined) throw new Error(`The file data/player/${name}.js is not of this page.`);
    return value;
  }

  /** Numbers of four bytes: the lowest byte of every number, then every second, third and highest. */
  async function unpack(text) {
    if (typeof DecompressionStream === "undefined") {
      throw new Error("This browser cannot unpack the recordings; one of 2023 or later can.");
    }
    const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
    const bytes = new Uint8Array(await new Response(stream).arrayBuffer()), n = bytes.length / 4;
    return Uint32Array.from({ length: n }, (_, i) => bytes[i] | (bytes[n + i] << 8) | (bytes[2 * n + i] << 16) | (bytes[3 * n + i] << 24));
  }

  /** Take columns [T, K] by name from numbers: 0 for none, or else one more than the zig-zag of a change since the last. */
  async function decode(text, T, columns) {
    const numbers = await unpack(text), found = {};
    let at = 0;
    for (const [K, quantum, ...names] of columns) {
      for (const name of names) {
        const out = (found[name] = new Float64Array(T * K).fill(NaN));
        for (let k = 0, value = 0; k < K; k++) {
          for (let i = k; i < out.length; i += K) {
            const number = numbers[at++] - 1;
            if (number < 0) continue;
            value += (number >>> 1) ^ -(number & 1);
            out[i] = value * quantum;
          }
        }
      }
    }
    return found;
  }

  const places = (K) => [[1, METRE, "x", "y"], [1, RADIAN, "yaw"], [K, METRE, "px", "py"]];
  const isThere = (values) => Uint8Array.from(values, (value) => value === value);

  /** A sequence: what is published of it, and its truth; [T] of the observer, [T, K] of the people. */
  async function decodeClip(value) {
    const T = value.frames, K = value.tracks.length, boxes = [[K, PIXEL, "u", "v", "l"], [K, 1, "given"]];
    const clip = { ...value, T, K, ...(await decode(value.data, T, [...places(K), ...boxes])) };
    return Object.assign(clip, { known: isThere(clip.px), observed: isThere(clip.u), given: isThere(clip.given) });
  }

  /** What a solver says of a clip, in the clip's own coordinates. */
  const decodeEstimate = (value, { T, K }) => decode(value.data, T, places(K));

  /* A moment: what is so at a frame, between two if need be. */

  /** Between two values, angles and columns of a panorama the shorter way around; of an unknown one the nearer. */
  function between(a, b, share, turn) {
    if (share === 0 || a !== a || b !== b) return share < 0.5 ? a : b;
    const step = b - a;
    return a + share * (turn ? step - turn * Math.round(step / turn) : step);
  }

  /** A row of values [T, K] in arrays that are made once. */
  function blend(from, out, frame, share, turn = 0) {
    const K = out.length, row = frame * K, next = row + K < from.length ? row + K : row;
    for (let k = 0; k < K; k++) out[k] = between(from[row + k], from[next + k], share, turn);
  }

  class Moment {
    constructor(clip, estimates) {
      const { K } = clip, room = (source) => ({ source, px: new Float64Array(K), py: new Float64Array(K), x: 0, y: 0, yaw: 0 });
      this.boxes = { u: new Float64Array(K), v: new Float64Array(K), l: new Float64Array(K) };
      Object.assign(this, { clip, truth: room(clip), estimates: estimates.map(room), frame: 0, share: 0 });
    }

    /** Go to frame `at`, between two if `smooth`, otherwise to the earlier; boxes stay with a picture of it if `pictured`. */
    go(at, smooth, pictured) {
      const { clip } = this, frame = Math.floor(at), share = smooth ? at - frame : 0, turn = clip.picture.round ? clip.picture.width : 0;
      Object.assign(this, { frame, share });
      for (const room of [this.truth, ...this.estimates]) {
        const { source } = room, next = Math.min(frame + 1, clip.T - 1);
        for (const name of ["px", "py"]) blend(source[name], room[name], frame, share);
        for (const name of ["x", "y", "yaw"]) {
          room[name] = between(source[name][frame], source[name][next], share, name === "yaw" ? 2 * Math.PI : 0);
        }
      }
      for (const name of ["u", "v", "l"]) blend(clip[name], this.boxes[name], frame, pictured ? 0 : share, name === "u" ? turn : 0);
    }
  }

  /** Add to an estimate its errors: `dx` [T] in m, the mean over people who are scored, `dt` in m and `dr` in rad. */
  function addErrors(estimate, clip, given) {
    const { T, K } = clip;
    for (const name of ["dx", "dt", "dr"]) estimate[name] = new Float64Array(T).fill(NaN);
    for (let t = START; t < T; t++) {
      let sum = 0, found = 0;
      for (let i = t * K; i < (t + 1) * K; i++) {
        const scored = clip.observed[i] && clip.known[i] && !(given === "arrivals" && clip.given[i]);
        const error = Math.hypot(estimate.px[i] - clip.px[i], estimate.py[i] - clip.py[i]);
        if (scored && !Number.isNaN(error)) { sum += error; found++; }
      }
      if (found) estimate.dx[t] = sum / found;
      estimate.dt[t] = Math.hypot(estimate.x[t] - clip.x[t], estimate.y[t] - clip.y[t]);
      estimate.dr[t] = Math.abs(wrap(estimate.yaw[t] - clip.yaw[t]));
    }
    return estimate;
  }

  /** [T] the error of a frame, its mean over solvers, or of two the difference; beyond the cap it counts less and less. */
  function signal(curves, cap) {
    const tame = (value) => value / (1 + value / cap);
    return Array.from(curves[0] || [], (_, t) => {
      const values = curves.map((curve) => tame(curve[t])).filter((value) => value === value);
      if (curves.length === 2) return values.length === 2 ? Math.abs(values[0] - values[1]) : 0;
      return values.reduce((sum, value) => sum + value, 0) / curves.length;
    });
  }

  /** The frame of the largest error, where a solver is lost or two differ most; the first of nearly equal ones. */
  function worstFrame(curves, cap) {
    const error = signal(curves, cap), most = Math.max(...error, 0);
    return most > 0 ? error.findIndex((value) => value >= 0.95 * most) : -1;
  }

  /* Drawing: colours of the page, marks of solvers, sharp canvases. */

  const COLOURS = ["ink", "paper", "faint", "line", "accent", "warn"];
  const SHAPES = ["square", "triangle", "diamond", "kite", "plus", "cross", "pentagon", "hexagon"];
  const CORNERS = { triangle: [1.2, 3, -0.5], diamond: [1.2, 4, 0], kite: [1.2, 3, 0.5], pentagon: [1.1, 5, -0.5], hexagon: [1.1, 6, 0] };
  /* Of a mark: its radius, how many corners it has, and by how many half circles the first is turned. */

  /** The colours of now, as a part of the page has them: of solvers by number, and of people [K] by slots of a palette. */
  function readTheme(root, numbers, slots, palette) {
    const probe = root.appendChild(document.createElement("i")), dark = vbbench.isDark();
    const read = (name) => {
      probe.style.color = `var(--${name})`;
      return getComputedStyle(probe).color;
    };
    const theme = Object.fromEntries(COLOURS.map((name) => [name, read(name)]));
    const solvers = new Map(numbers.map((number) => [number, read(`solver-${number}`)]));
    probe.remove();
    return { ...theme, dark, solvers, people: slots.map((slot) => palette[dark ? "dark" : "light"][slot]) };
  }

  /** Call back whenever the page turns dark or light; returns how to stop. */
  function onTheme(changed) {
    const observer = new MutationObserver(changed), media = matchMedia("(prefers-color-scheme: dark)");
    observer.observe(document.documentElement, { attributes: true, attributeFilter: ["data-theme"] });
    media.addEventListener("change", changed);
    return () => { observer.disconnect(); media.removeEventListener("change", changed); };
  }

  /** Add a solver's mark to the path of a canvas. */
  function addMark(context, shape, x, y, r) {
    if (shape === "square") context.rect(x - 0.85 * r, y - 0.85 * r, 1.7 * r, 1.7 * r);
    else if (shape in CORNERS) {
      const [size, corners, turn] = CORNERS[shape];
      for (let i = 0; i <= corners; i++) {
        const angle = Math.PI * (turn + (2 * i) / corners);
        context[i ? "lineTo" : "moveTo"](x + size * r * Math.cos(angle), y + size * r * Math.sin(angle));
      }
    } else {
      for (const [dx, dy] of shape === "plus" ? [[r, 0], [0, r]] : [[0.8 * r, 0.8 * r], [-0.8 * r, 0.8 * r]]) {
        context.moveTo(x - dx, y - dy); context.lineTo(x + dx, y + dy);
      }
    }
  }

  /** Make a canvas fill its box at the screen's own resolution; true if that changed anything. */
  function fit(canvas) {
    const ratio = Math.min(window.devicePixelRatio || 1, 3);
    const width = Math.round(canvas.clientWidth * ratio), height = Math.round(canvas.clientHeight * ratio);
    const changed = canvas.width !== width || canvas.height !== height;
    if (changed) Object.assign(canvas, { width, height });
    canvas.ratio = ratio;
    return changed;
  }

  function clear({ canvas, context }, paper) {
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.fillStyle = paper;
    context.fillRect(0, 0, canvas.width, canvas.height);
  }

  function type(context, size, textAlign, textBaseline) {
    Object.assign(context, { font: `${size}px ${FONT}`, textAlign, textBaseline });
  }

  /** Text with a halo of paper, readable on anything. */
  function label(context, text, x, y, colour, halo) {
    Object.assign(context, { lineWidth: 3, lineJoin: "round", strokeStyle: halo, fillStyle: colour });
    context.strokeText(text, x, y);
    context.fillText(text, x, y);
  }

  /** Draw with another opacity than all else. */
  function faintly(context, alpha, act) {
    context.globalAlpha = alpha;
    act();
    context.globalAlpha = 1;
  }

  /** What the observer sees: boxes on a strip of the panorama, or in the picture of a camera with borders. */
  class EgoView {
    static ASPECT = 0.38; // width of a person's box over its height
    static FILL = { plain: 0.22, pictured: 0.1 }; // opacity
    static SMALL = 6; // half the width in CSS px under which boxes have corners
    static MARKS = [["back", 0, "left"], ["left", 0.25, "center"], ["ahead", 0.5, "center"], ["right", 0.75, "center"], ["back", 1, "right"]];

    constructor(canvas) {
      Object.assign(this, { canvas, context: canvas.getContext("2d"), order: [] });
    }

    /** Begin a clip with so many pictures, addressed by frame: the shape of the view follows its camera. */
    start(clip, pictures, address, loaded) {
      const { width, height, round } = clip.picture, { canvas } = this;
      Object.assign(this, { clip, pictures, images: [], address, loaded, shown: clip.picture, order: [...clip.tracks.keys()] });
      canvas.style.aspectRatio = `${width} / ${height}`;
      canvas.style.setProperty("--aspect", width / height);
      canvas.parentElement.classList.toggle("player-round", round);
    }

    /** The picture of a frame, and the next few asked for; null until it is loaded. */
    picture(frame) {
      for (let t = frame; t < Math.min(frame + 4, this.pictures); t++) {
        this.images[t] ||= Object.assign(new Image(), { onload: this.loaded, src: this.address(t) });
      }
      const image = this.images[frame];
      return image?.complete && image.naturalWidth ? image : null;
    }

    /** On a narrow screen, move the panorama to where most boxes of a moment are; straight ahead if there are none. */
    turnTo({ boxes }) {
      const around = this.canvas.parentElement, wide = around.clientWidth, rate = this.canvas.clientWidth / this.shown.width;
      const places = [...boxes.u].filter((u) => u === u).map((u) => u * rate);
      const near = (place) => places.filter((other) => Math.abs(other - place) < 0.45 * wide).length;
      const best = places.reduce((one, other) => (near(other) > near(one) ? other : one), places[0] ?? this.canvas.clientWidth / 2);
      around.scrollLeft = best - wide / 2;
    }

    draw(moment, theme, options) {
      const { context, canvas, clip, shown } = this;
      fit(canvas);
      this.scale = canvas.width / shown.width;
      this.thin = canvas.ratio / this.scale;
      clear(this, theme.paper);
      this.drawGround(moment, theme);
      context.setTransform(this.scale, 0, 0, this.scale, 0, -shown.top * this.scale);
      this.order.sort((a, b) => (moment.boxes.l[a] || 0) - (moment.boxes.l[b] || 0));
      for (const k of this.order) this.drawBox(moment, k, theme, options);
      if (clip.picture.round) this.drawCompass(theme);
      if (options.selected >= 0) this.drawSelected(moment, theme, options.selected);
      else if (options.ids) this.drawIds(moment, theme);
    }

    drawGround(moment, theme) {
      const { context, canvas, shown, scale } = this, picture = this.picture(moment.frame);
      if (picture) {
        const rate = picture.naturalWidth / shown.width, part = [0, shown.top, shown.width, shown.height].map((side) => side * rate);
        context.drawImage(picture, ...part, 0, 0, canvas.width, canvas.height);
        return;
      }
      const rows = shown.horizon.map((row) => (row - shown.top) * scale), level = rows.every((row) => row === rows[0]);
      const line = level ? rows.map(Math.round) : rows, thick = Math.max(1, canvas.ratio);
      context.fillStyle = theme.ink;
      faintly(context, 0.06, () => this.fillBelow(rows, rows.map(() => canvas.height)));
      context.fillStyle = theme.line;
      this.fillBelow(line, line.map((row) => row + thick));
    }

    /** Fill the canvas between two lines, given by their rows at columns evenly from border to border. */
    fillBelow(rows, bottoms) {
      const { context, canvas } = this, step = canvas.width / (rows.length - 1);
      context.beginPath();
      rows.forEach((row, n) => context.lineTo(n * step, row));
      bottoms.forEach((_, n) => context.lineTo(canvas.width - n * step, bottoms[bottoms.length - 1 - n]));
      context.fill();
    }

    /** Left, top, width and height of a box; twice where the border of a panorama cuts it. */
    rectangles(u, v, l) {
      const { round, width } = this.clip.picture, half = 0.5 * EgoView.ASPECT * l, at = (column) => [column - half, v - l / 2, 2 * half, l];
      const isCut = round && (u < half || u > width - half);
      return isCut ? [at(u), at(u + (u < half ? 1 : -1) * width)] : [at(u)];
    }

    drawBox(moment, k, theme, options) {
      const { u, v, l } = moment.boxes, { context, thin, pictures } = this;
      if (l[k] !== l[k]) return;
      const alarm = options.isAlarm(moment.frame, k), colour = alarm ? theme.warn : theme.people[k];
      for (const [left, top, width, height] of this.rectangles(u[k], v[k], l[k])) {
        const lineWidth = (pictures ? 1.8 : 1.4) * thin;
        context.beginPath();
        context.roundRect(left, top, width, height, alarm || width < 2 * EgoView.SMALL * thin ? 0 : 0.25 * width);
        if (pictures) { // a line of the paper's shade, so that the colour shows on any picture
          Object.assign(context, { lineWidth: 2.2 * lineWidth, strokeStyle: theme.dark ? "rgb(0 0 0 / 60%)" : "rgb(255 255 255 / 75%)" });
          context.stroke();
        }
        Object.assign(context, { lineWidth, strokeStyle: colour, fillStyle: colour });
        if (alarm) this.crossOut(left, top, width, height);
        else faintly(context, EgoView.FILL[pictures ? "pictured" : "plain"], () => context.fill());
        context.stroke();
        context.setLineDash([]);
      }
    }

    /** Mark a box that shows nobody: a cross, and a dashed border to be drawn. */
    crossOut(left, top, width, height) {
      const { context, thin } = this, cross = new Path2D(`M${left} ${top}l${width} ${height}m0 ${-height}l${-width} ${height}`);
      faintly(context, 0.5, () => context.stroke(cross));
      context.setLineDash([5 * thin, 3 * thin]);
    }

    drawCompass(theme) {
      const { context, shown, thin } = this, size = 11 * thin;
      for (const [name, share, align] of EgoView.MARKS) {
        const x = share * shown.width, away = { left: 0.5, center: 0, right: -0.5 }[align] * size;
        type(context, size, align, "top");
        label(context, name, x + away, shown.top + 0.5 * size, this.pictures ? theme.ink : theme.faint, theme.paper);
        context.fillStyle = theme.faint;
        context.fillRect(x - 0.05 * size, shown.top, 0.1 * size, 0.4 * size);
      }
    }

    /** Ids over the nearest boxes, as far as they do not cover one another. */
    drawIds(moment, theme) {
      const { context, thin, clip, shown } = this, size = 10 * thin, taken = [], { u, v, l } = moment.boxes;
      type(context, size, "center", "bottom");
      for (const k of [...this.order].reverse()) {
        if (l[k] !== l[k] || taken.length > 47 || taken.some((other) => Math.abs(other - u[k]) <= 2.4 * size)) continue;
        taken.push(u[k]);
        label(context, clip.tracks[k], u[k], Math.max(v[k] - l[k] / 2 - 0.2 * size, shown.top + 3 * size), theme.ink, theme.paper);
      }
    }

    drawSelected(moment, theme, n) {
      const { u, v, l } = moment.boxes;
      if (!(l[n] === l[n])) return;
      const { context, thin, clip, shown, scale } = this, size = 12 * thin, half = 0.5 * EgoView.ASPECT * l[n] + 3 / scale;
      Object.assign(context, { lineWidth: 2.5 * thin, strokeStyle: theme.accent });
      context.strokeRect(u[n] - half, v[n] - l[n] / 2, 2 * half, l[n]);
      type(context, size, "center", "bottom");
      const x = Math.min(Math.max(u[n], 3 * size), shown.width - 3 * size), y = Math.max(v[n] - l[n] / 2 - 0.2 * size, shown.top + 2.6 * size);
      label(context, `person ${clip.tracks[n]}`, x, y, theme.ink, theme.paper);
    }

    /** The nearest person whose box lies under a point of the view (CSS px), or -1. */
    pick({ boxes: { u, v, l } }, x, y) {
      const rate = this.shown.width / this.canvas.clientWidth, column = x * rate, row = y * rate + this.shown.top, slack = 3 * rate;
      return this.order.findLast((n) =>
        Math.abs(u[n] - column) < 0.5 * EgoView.ASPECT * l[n] + slack && Math.abs(v[n] - row) < l[n] / 2 + slack) ?? -1;
    }
  }

  const TRAIL = { seconds: 4, points: 3000, fastest: 6 };
  /* A crowd's trails are shorter, so that they take no longer; where somebody true is faster, in m/s, a track went over. */

  /** Past frames of those who are there, and of the observer, as a path in m; made once a frame. */
  function trailOf(room, moment) {
    const { clip, frame } = moment, { source, trail } = room, { K, dt } = clip;
    if (trail?.frame === frame) return trail.path;
    const from = Math.max(0, frame - Math.min(Math.round(TRAIL.seconds / dt), Math.ceil(TRAIL.points / K))), path = new Path2D();
    const isKnown = (i) => source.px[i] === source.px[i];
    const leaps = (i) => source === clip && Math.hypot(source.px[i] - source.px[i - K], source.py[i] - source.py[i - K]) > TRAIL.fastest * dt;
    for (let k = 0; k < K; k++) {
      if (!isKnown(frame * K + k)) continue;
      for (let t = from, i = from * K + k; t <= frame; t++, i += K) {
        const goesOn = t > from && isKnown(i - K) && !leaps(i);
        if (isKnown(i)) path[goesOn ? "lineTo" : "moveTo"](source.px[i], source.py[i]);
      }
    }
    for (let t = from; t <= frame; t++) path[t > from ? "lineTo" : "moveTo"](source.x[t], source.y[t]);
    room.trail = { frame, path };
    return path;
  }

  /** From the last frame to where everybody is between two. */
  function endsOf({ source, px, py, x, y }, moment) {
    const { clip, frame } = moment, path = new Path2D(), { K } = clip;
    const add = (from, up, to, high) => { path.moveTo(from, up); path.lineTo(to, high); };
    for (let k = 0, i = frame * K; k < K; k++, i++) {
      if (source.px[i] === source.px[i] && px[k] === px[k]) add(source.px[i], source.py[i], px[k], py[k]);
    }
    add(source.x[frame], source.y[frame], x, y);
    return path;
  }

  /** The map from above: true people and camera, up to three solvers' estimates, trails, error lines, a metric grid. */
  class MapView {
    static PERSON = 0.22; // radius of a person in m
    static STEPS = [0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1e3, 2e3, 5e3, 1e4, 1e5];
    static AROUND = { crowd: 1.5, way: 15 }; // m around the crowd, or around the camera's way where nobody's place is known
    static POINTER = 14; // CSS px within which a person is found

    constructor(canvas) {
      Object.assign(this, { canvas, context: canvas.getContext("2d") });
      this.view = { x: 0, y: 0, scale: 40 }; // centre in m, CSS px a metre
      this.legend = canvas.parentElement.querySelector(".player-legend");
      this.below = 0; // CSS px at the bottom, under the legend
      this.home = true; // still as `fitTruth` left it
    }

    start(clip) {
      Object.assign(this, { clip, home: true });
    }

    sx(x) { return this.ox + x * this.k; }
    sy(y) { return this.oy - y * this.k; }

    /** Look at all who are ever seen, where they truly are; where that is not known, at what is around the camera's way. */
    fitTruth() {
      const { clip, canvas, view } = this, around = MapView.AROUND[clip.known.includes(1) ? "crowd" : "way"];
      const seen = (values, own) => extent([...values.filter((_, i) => clip.observed[i]), ...own], around);
      const [left, right] = seen(clip.px, clip.x), [low, high] = seen(clip.py, clip.y);
      view.scale = Math.min(canvas.clientWidth / (right - left), (canvas.clientHeight - this.below) / (high - low)) || 40;
      view.x = (left + right) / 2;
      view.y = (low + high) / 2 - this.below / 2 / view.scale; // above the legend
      this.home = true;
    }

    /** Zoom by a factor about a point of the canvas (CSS px). */
    zoom(factor, x, y) {
      const { view, canvas } = this, before = view.scale;
      view.scale = Math.min(Math.max(before * factor, 1e-4), 2000);
      const gain = 1 / before - 1 / view.scale;
      view.x += (x - canvas.clientWidth / 2) * gain;
      view.y -= (y - canvas.clientHeight / 2) * gain;
      this.home = false;
    }

    pan(dx, dy) {
      this.view.x -= dx / this.view.scale;
      this.view.y += dy / this.view.scale;
      this.home = false;
    }

    /** Draw a moment; `solvers` are { colour, shape } in the order of the moment's estimates. */
    draw(moment, solvers, theme, options) {
      const { canvas, view } = this, { truth } = moment;
      if (fit(canvas) || this.fresh !== this.clip) {
        this.below = this.legend.offsetHeight + 14;
        if (this.home) this.fitTruth();
        this.fresh = this.clip;
      }
      this.k = view.scale * canvas.ratio;
      this.ox = canvas.width / 2 - view.x * this.k;
      this.oy = canvas.height / 2 + view.y * this.k;
      clear(this, theme.paper);
      this.drawGrid(theme);
      this.drawSight(truth, theme);
      this.drawTrails(moment, solvers, theme);
      this.drawPeople(moment, theme, options);
      moment.estimates.forEach((room, n) => this.drawEstimate(moment, room, solvers[n], options));
      this.drawCamera(truth, theme.ink, theme.paper);
      if (options.selected >= 0) this.drawSelected(moment, theme, options.selected);
      else if (options.ids) this.drawIds(moment, theme);
      this.drawScale(theme);
    }

    drawGrid(theme) {
      const { context, canvas, k, ox, oy, clip } = this, { ratio, width, height } = canvas;
      this.step = MapView.STEPS.find((metres) => metres * k >= 48 * ratio) || 1e6;
      /* Places of the grid's lines on an axis, each with its coordinate in the scene, a multiple of the step. */
      const marks = (axis, low, high) => {
        const shift = clip.origin[axis], first = Math.ceil((low + shift) / this.step), last = Math.floor((high + shift) / this.step);
        return Array.from({ length: last - first + 1 }, (_, n) => (first + n) * this.step).map((at) => [at - shift, String(+at.toFixed(1))]);
      };
      const columns = marks(0, -ox / k, (width - ox) / k), rows = marks(1, (oy - height) / k, oy / k);
      Object.assign(context, { lineWidth: Math.max(1, Math.round(ratio / 2)), strokeStyle: theme.line, fillStyle: theme.faint });
      context.beginPath();
      for (const [place] of columns) {
        const x = Math.round(this.sx(place)) + 0.5;
        context.moveTo(x, 0); context.lineTo(x, height);
      }
      for (const [place] of rows) {
        const y = Math.round(this.sy(place)) + 0.5;
        context.moveTo(0, y); context.lineTo(width, y);
      }
      faintly(context, 0.7, () => context.stroke());
      type(context, 10 * ratio, "left", "top");
      for (const [place, text] of columns) context.fillText(text, this.sx(place) + 3 * ratio, 3 * ratio);
      context.textBaseline = "bottom";
      for (const [place, text] of rows) {
        if (this.sy(place) > 26 * ratio) context.fillText(text, 3 * ratio, this.sy(place) - 2 * ratio);
      }
    }

    /** Where everybody came from, in m on a canvas that is scaled. */
    drawTrails(moment, solvers, theme) {
      const { context, canvas, k } = this;
      context.setTransform(k, 0, 0, -k, this.ox, this.oy);
      [moment.truth, ...moment.estimates].forEach((room, n) => {
        const [alpha, width, strokeStyle] = n ? [0.6, 1.2, solvers[n - 1].colour] : [0.28, 1.5, theme.ink];
        Object.assign(context, { lineWidth: (width * canvas.ratio) / k, lineJoin: "bevel", strokeStyle });
        faintly(context, alpha, () => context.stroke(trailOf(room, moment)));
        if (moment.share > 0) faintly(context, alpha, () => context.stroke(endsOf(room, moment)));
      });
      context.setTransform(1, 0, 0, 1, 0, 0);
    }

    circle(x, y, radius) {
      const sx = this.sx(x), sy = this.sy(y);
      this.context.moveTo(sx + radius, sy);
      this.context.arc(sx, sy, radius, 0, 2 * Math.PI);
    }

    drawSight({ x, y, yaw }, theme) {
      const { context } = this, { round, view } = this.clip.picture, [left, right] = view || [-0.35, 0.35];
      const reach = (round ? 2.2 : 12) * this.k;
      Object.assign(context, { fillStyle: theme.accent, strokeStyle: theme.accent, lineWidth: this.canvas.ratio });
      context.beginPath();
      context.moveTo(this.sx(x), this.sy(y));
      context.arc(this.sx(x), this.sy(y), reach, -yaw + left, -yaw + right);
      faintly(context, 0.12, () => context.fill());
      context.beginPath();
      this.circle(x, y, reach);
      if (round) faintly(context, 0.4, () => context.stroke());
    }

    drawPeople(moment, theme, options) {
      const { context, clip, canvas } = this, { px, py } = moment.truth, base = moment.frame * clip.K;
      const radius = Math.max(MapView.PERSON * this.k, 2.5 * canvas.ratio);
      const people = [...clip.tracks.keys()].filter((n) => px[n] === px[n]);
      for (const n of people) {
        context.beginPath();
        this.circle(px[n], py[n], radius);
        context.fillStyle = theme.people[n];
        faintly(context, clip.observed[base + n] ? 1 : 0.3, () => context.fill());
      }
      context.beginPath();
      for (const n of people) if (options.isGiven(moment.frame, n)) this.circle(px[n], py[n], radius + 3 * canvas.ratio);
      Object.assign(context, { lineWidth: 1.2 * canvas.ratio, strokeStyle: theme.ink }).stroke();
    }

    drawEstimate(moment, room, solver, options) {
      const { context, canvas, clip, k } = this, { truth } = moment;
      const radius = Math.max(0.8 * MapView.PERSON * k, 3.2 * canvas.ratio);
      const line = (from, to, up, n) => { context.moveTo(this.sx(from), this.sy(up)); context.lineTo(this.sx(to), this.sy(n)); };
      context.beginPath();
      for (let n = 0; n < clip.K; n++) {
        if (room.px[n] === room.px[n] && truth.px[n] === truth.px[n]) line(truth.px[n], room.px[n], truth.py[n], room.py[n]);
      }
      line(truth.x, room.x, truth.y, room.y);
      Object.assign(context, { lineWidth: 1.6 * canvas.ratio, strokeStyle: solver.colour }).stroke();
      context.beginPath();
      for (let n = 0; n < clip.K; n++) {
        const shown = room.px[n] === room.px[n] && !options.isGiven(moment.frame, n);
        if (shown) addMark(context, solver.shape, this.sx(room.px[n]), this.sy(room.py[n]), radius);
      }
      Object.assign(context, { lineWidth: 1.6 * canvas.ratio, strokeStyle: solver.colour }).stroke();
      this.drawCamera(room, solver.colour, null);
    }

    /** An arrowhead that looks where the observer looks. */
    drawCamera(place, colour, rim) {
      const { context, canvas } = this, size = Math.max(0.34 * this.k, 8 * canvas.ratio), x = this.sx(place.x), y = this.sy(place.y);
      if (place.x !== place.x) return;
      context.beginPath();
      for (const [turn, reach] of [[0, 1.15], [2.45, 1], [Math.PI, 0.35], [-2.45, 1]]) {
        context.lineTo(x + size * reach * Math.cos(place.yaw + turn), y - size * reach * Math.sin(place.yaw + turn));
      }
      context.closePath();
      Object.assign(context, { lineWidth: 2 * canvas.ratio, strokeStyle: rim || colour, fillStyle: colour }).stroke();
      if (rim) context.fill();
    }

    /** The person, true or estimated, nearest to a point of the canvas (CSS px), or -1. */
    pick(moment, x, y) {
      const { ratio } = this.canvas;
      let best = MapView.POINTER * ratio, found = -1;
      for (const { px, py } of [moment.truth, ...moment.estimates]) {
        px.forEach((place, n) => {
          const off = Math.hypot(this.sx(place) - x * ratio, this.sy(py[n]) - y * ratio);
          if (off < best) { best = off; found = n; }
        });
      }
      return found;
    }

    drawIds(moment, theme) {
      const { context, canvas: { ratio }, clip } = this, { px, py } = moment.truth;
      type(context, 10 * ratio, "left", "middle");
      for (let n = 0; n < clip.K; n++) {
        const at = [this.sx(px[n]) + 7 * ratio, this.sy(py[n]) - 7 * ratio];
        if (px[n] === px[n]) label(context, clip.tracks[n], ...at, theme.ink, theme.paper);
      }
    }

    drawSelected(moment, theme, n) {
      const { context, canvas: { ratio }, clip } = this, px = moment.truth.px[n], py = moment.truth.py[n];
      if (px !== px) return;
      context.beginPath();
      this.circle(px, py, Math.max(0.42 * this.k, 10 * ratio));
      Object.assign(context, { lineWidth: 2.5 * ratio, strokeStyle: theme.accent }).stroke();
      type(context, 12 * ratio, "left", "middle");
      label(context, `person ${clip.tracks[n]}`, this.sx(px) + 14 * ratio, this.sy(py) - 12 * ratio, theme.ink, theme.paper);
    }

    drawScale(theme) {
      const { context, canvas, k, step } = this, { ratio } = canvas, long = step * k;
      const x = canvas.width - long - 12 * ratio, y = canvas.height - 12 * ratio;
      context.beginPath();
      for (const [across, up] of [[0, 5], [0, 0], [long, 0], [long, 5]]) context.lineTo(x + across, y - up * ratio);
      Object.assign(context, { lineWidth: 1.5 * ratio, strokeStyle: theme.ink }).stroke();
      type(context, 11 * ratio, "center", "bottom");
      label(context, `${step} m`, x + long / 2, y - 3 * ratio, theme.ink, theme.paper);
    }
  }

  /** The least and the largest value that is known, and so much more. */
  function extent(values, around) {
    const known = values.filter((value) => value === value);
    const [low, high] = [Math.min, Math.max].map((end) => known.reduce((one, other) => end(one, other), known[0]));
    return [low - around, high + around];
  }

  /** The strip under the scrubber: error over time, a line a solver; what is given, and the frame of the largest error. */
  class Strip {
    static LEFT = 34;
    static RIGHT = 6;
    static TOP = 14;
    static BOTTOM = 19; // CSS px, as all of these
    static STEEP = 8; // a solver that is so many times worse than another is cut off at the top

    constructor(canvas) {
      Object.assign(this, { canvas, context: canvas.getContext("2d") });
    }

    /** Curves are { colour, values [T] }, given [T] whether any position is, worst a frame or -1. */
    show(curves, given, worst, theme) {
      const largest = curves.map(({ values }) => Math.max(...values.filter((v) => v === v), 0));
      const least = Math.min(...largest.filter((most) => most > 0)), whole = Math.max(...largest, 1e-3);
      const top = ceiling(whole > Strip.STEEP * least ? Math.max(2 * least, 1e-3) : whole);
      Object.assign(this, { curves, given, worst, frames: given.length, theme, whole, top });
    }

    draw(at) {
      const { canvas, context, theme, curves } = this, frame = Math.floor(at);
      fit(canvas);
      const { ratio } = canvas;
      context.clearRect(0, 0, canvas.width, canvas.height);
      this.drawGiven(ratio);
      this.drawAxes(ratio);
      for (const curve of curves) this.drawCurve(curve, ratio);
      this.drawNotes(ratio);
      context.fillStyle = theme.accent;
      context.fillRect(this.x(at) - ratio, 0, 2 * ratio, canvas.height - Strip.BOTTOM * ratio);
      for (const { colour, values } of curves) {
        if (values[frame] !== values[frame]) continue;
        context.beginPath();
        context.arc(this.x(frame), this.y(values[frame]), 3 * ratio, 0, 2 * Math.PI);
        context.fillStyle = colour;
        context.fill();
      }
    }

    x(at) {
      const { ratio, width } = this.canvas;
      return Strip.LEFT * ratio + (at / Math.max(1, this.frames - 1)) * (width - (Strip.LEFT + Strip.RIGHT) * ratio);
    }

    y(value) {
      const { ratio, height } = this.canvas, { TOP, BOTTOM } = Strip;
      return height - BOTTOM * ratio - (Math.min(value, 1.05 * this.top) / this.top) * (height - (TOP + BOTTOM) * ratio);
    }

    /** Frame at a column of the canvas (CSS px). */
    frameAt(column) {
      const share = (column - Strip.LEFT) / (this.canvas.clientWidth - Strip.LEFT - Strip.RIGHT);
      return Math.round(Math.min(Math.max(share, 0), 1) * (this.frames - 1));
    }

    /** A band where everything is given, and a tick under every frame in which somebody's position is. */
    drawGiven(ratio) {
      const { context } = this, low = this.y(0), wide = Math.max(ratio, Math.min(3 * ratio, this.x(1) - this.x(0) - ratio));
      context.fillStyle = this.theme.ink;
      faintly(context, 0.07, () => context.fillRect(this.x(0), 0, this.x(Math.min(START, this.frames) - 0.5) - this.x(0), low));
      faintly(context, 0.55, () => this.given.forEach((given, t) => {
        if (given) context.fillRect(this.x(t) - wide / 2, low + ratio, wide, 4 * ratio);
      }));
    }

    drawAxes(ratio) {
      const { canvas, context, theme, top, whole } = this, { LEFT, RIGHT } = Strip;
      type(context, 10 * ratio, "right", "middle");
      for (const share of [0, 0.5, 1]) {
        context.fillStyle = theme.line;
        context.fillRect(LEFT * ratio, Math.round(this.y(share * top)), canvas.width - (LEFT + RIGHT) * ratio, 1);
        context.fillStyle = theme.faint;
        context.fillText(String(+(share * top).toPrecision(3)), (LEFT - 5) * ratio, this.y(share * top));
      }
      type(context, 10 * ratio, "center", "bottom");
      const every = [1, 2, 5, 10, 20, 50, 100, 200, 500].find((n) => this.frames / n <= 10) || 1000;
      for (let t = 0; t < this.frames; t += every) context.fillText(t, this.x(t), canvas.height);
    }

    drawCurve({ colour, values }, ratio) {
      const { context } = this;
      context.beginPath();
      values.forEach((value, t) => {
        if (value === value) context[values[t - 1] === values[t - 1] ? "lineTo" : "moveTo"](this.x(t), this.y(value));
      });
      Object.assign(context, { lineWidth: 1.6 * ratio, strokeStyle: colour }).stroke();
    }

    /** How far curves go that are cut off, and the frame of the largest error. */
    drawNotes(ratio) {
      const { canvas, context, theme, top, whole, worst } = this, x = this.x(worst), size = 5 * ratio;
      if (whole > 1.05 * top) {
        type(context, 10 * ratio, "right", "middle");
        label(context, `↑ up to ${short(whole)}`, canvas.width - (Strip.RIGHT + 2) * ratio, this.y(top) + 8 * ratio, theme.ink, theme.paper);
      }
      if (worst < 0) return;
      context.fillStyle = theme.accent;
      context.beginPath();
      context.moveTo(x - size, ratio); context.lineTo(x + size, ratio); context.lineTo(x, ratio + 1.5 * size);
      context.fill();
    }
  }

  /** The next round number. */
  function ceiling(value) {
    const decade = 10 ** Math.floor(Math.log10(value));
    return decade * [1, 1.5, 2, 3, 4, 6, 8, 10].find((step) => step * decade >= value * 0.999);
  }

  /* Pointer, wheel and touch on the views. */

  const CLICK = 5; // CSS px that a click may wander

  /** Drag to pan, wheel or pinch to zoom, hover and click to find a person. Handlers: pan, zoom, hover, click. */
  function onMap(canvas, handlers) {
    const held = new Map(), at = ({ clientX, clientY }) => {
      const box = canvas.getBoundingClientRect();
      return [clientX - box.left, clientY - box.top];
    };
    let travelled = 0;
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      handlers.zoom(Math.exp(-0.0016 * (event.deltaMode === 1 ? 16 : 1) * event.deltaY), ...at(event));
    }, { passive: false });
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      held.set(event.pointerId, at(event));
      if (held.size === 1) travelled = 0;
    });
    canvas.addEventListener("pointermove", (event) => {
      const now = at(event), before = held.get(event.pointerId);
      if (!before) return handlers.hover(...now);
      const [other] = [...held].filter(([id]) => id !== event.pointerId).map(([, place]) => place);
      const move = now.map((value, axis) => value - before[axis]);
      held.set(event.pointerId, now);
      travelled += Math.hypot(...move);
      if (other) {
        const apart = ([x, y]) => Math.hypot(x - other[0], y - other[1]) || 1;
        handlers.pan(move[0] / 2, move[1] / 2);
        handlers.zoom(apart(now) / apart(before), (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
      } else if (travelled > CLICK) handlers.pan(...move);
    });
    for (const name of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(name, (event) => {
        const was = held.delete(event.pointerId);
        if (was && name === "pointerup" && travelled <= CLICK) handlers.click(...at(event));
      });
    }
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

  /* Controls: native buttons, selects, check boxes and sliders, and what they are called. */

  const ICONS = {
    start: "M5 4v16M20 4 9 12l11 8z", back: "M16 5 7 12l9 7z", play: "M7 4l13 8-13 8z", pause: "M7 4v16M17 4v16",
    on: "M8 5l9 7-9 7z", end: "M19 4v16M4 4l11 8-11 8z", fit: "M4 9V4h5M15 4h5v5M20 15v5h-5M9 20H4v-5",
    link: "M9 15l6-6M10 6l2-2a4 4 0 0 1 6 6l-2 2M14 18l-2 2a4 4 0 0 1-6-6l2-2",
  };
  const icon = (name) => `<svg viewBox="0 0 24 24" aria-hidden="true"><path d="${ICONS[name]}"/></svg>`;
  const button = (name, text, content) => `<button type="button" data-do="${name}" title="${text}" aria-label="${text}">${content}</button>`;
  const choices = (name, pairs) => `<select data-${name}>${pairs.map(([value, text]) => `<option value="${value}">${text}</option>`).join("")}</select>`;

  const KEYS = [
    ["Space", "play or pause"], ["← →", "a frame back or on"], ["Home End", "first or last frame"],
    ["w", "the frame of the largest error"], ["+ −", "zoom"], ["Shift + arrows", "move the map"], ["0", "see where everybody truly is"],
    ["i", "ids"], ["?", "this help"],
  ];

  const TEMPLATE = `
    <div class="player-head">
      <label class="player-which"><span>Sequence</span> <select data-sequence></select></label>
      <label><span>Board</span> <select data-board></select></label>
      <span class="player-facts" data-facts></span>
      <span class="player-end">${button("link", "Copy a link to this frame", `${icon("link")}<span>Copy link</span>`)}${button("help", "Keys", "?")}</span>
    </div>
    <p class="player-gone" data-gone role="status" hidden></p>
    <p class="player-note" data-note role="status" hidden></p>
    <div class="player-body" data-body>
      <div class="player-sight" role="group" aria-label="What the observer sees" tabindex="0">
        <canvas class="player-ego" data-ego role="img"></canvas></div>
      <p class="player-boxes" data-boxes-line><span data-boxes><i class="player-box"></i> <span></span></span>
        <span data-alarms><i class="player-box player-alarm"></i> <span></span></span></p>
      <div class="player-ground">
        <canvas class="player-map" data-map role="img" tabindex="0"></canvas>
        <div class="player-zoom">${button("in", "Zoom in", "+")}${button("out", "Zoom out", "−")}${button("fit", "See where everybody truly is", icon("fit"))}</div>
        <p class="player-legend"><b><span class="player-true"></span> true place</b> <b><span class="player-true player-pale"></span> without a box</b>
          <b><span class="player-given"></span> given</b> <b><span class="player-cone"></span> camera</b></p>
      </div>
      <div class="player-side">
        <table class="player-solvers">
          <caption>Solvers, up to three</caption>
          <thead><tr><th scope="col">this frame, m</th><th scope="col" title="Mean error of the people's positions">Δx</th>
            <th scope="col" title="Error of the camera's position">Δt</th><th scope="col" title="Mean Δx of the whole sequence">mean Δx</th></tr></thead>
          <tbody data-solvers></tbody>
        </table>
        <div class="player-person"><label>Person <select data-person></select></label>
          <p data-person-text></p></div>
        <label class="player-check"><input type="checkbox" data-ids> Ids <kbd>i</kbd></label>
      </div>
      <div class="player-transport">
        <span class="player-buttons">${button("start", "First frame", icon("start"))}${button("previous", "One frame back", icon("back"))}${button("play", "Play", icon("play"))}${button("next", "One frame on", icon("on"))}${button("end", "Last frame", icon("end"))}</span>
        <input type="range" min="0" step="1" data-scrub aria-label="Frame">
        <output class="player-clock" data-clock></output>
        <label>Speed ${choices("speed", [["0.25", "¼×"], ["0.5", "½×"], ["1", "1×"], ["2", "2×"], ["4", "4×"]])}</label>
      </div>
      <div class="player-over-time">
        <label class="player-metric">Over time ${choices("metric", [["dx", "Δx, people, m"], ["dt", "Δt, camera, m"], ["dr", "Δr, camera, rad"]])}</label>
        ${button("worst", "Go to the frame of the largest error", `<span class="player-tip">▼</span> Largest error`)}
        <span class="player-key">grey and ticks: given</span>
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
    const root = element.firstElementChild, parts = [...root.querySelectorAll("*")];
    const named = parts.flatMap((part) => Object.keys(part.dataset).map((name) => [name, part]));
    return { ...Object.fromEntries(named), root, button: (name) => root.querySelector(`[data-do="${name}"]`) };
  }

  function list(select, pairs, value) {
    select.replaceChildren(...pairs.map(([key, text]) => new Option(text, key)));
    select.value = value;
  }

  /* What it is: what is chosen, what is loaded, the drawing of it, and what is said of it. */

  const MOST = 3, AT_FIRST = 2; // solvers at a time, and where the address names none

  class Session {
    constructor(element, { board, state, onState }) {
      this.ui = build(element);
      this.onState = onState || (() => {});
      this.views = { ego: new EgoView(this.ui.ego), map: new MapView(this.ui.map), strip: new Strip(this.ui.strip) };
      this.smooth = !matchMedia("(prefers-reduced-motion: reduce)").matches;
      Object.assign(this, { at: 0, playing: false, speed: 1, metric: "dx", pinned: -1, hovered: -1, turn: 0 });
      connect(this);
      this.open(board, state || {});
    }

    isGiven = (t, k) => {
      const { clip, board } = this, i = t * clip.K + k;
      return board.given !== "origin" && clip.observed[i] && (t < START || (board.given === "arrivals" && clip.given[i]));
    };

    /** Whether a box is known to show nobody: the truth has no place for it. */
    isAlarm = (t, k) => {
      const { clip, index } = this, i = t * clip.K + k;
      return index.truth !== "poses" && clip.observed[i] === 1 && !clip.known[i];
    };

    /** Show a board, { key: "SPLIT/PROTOCOL-TIER", solvers: [{ name, colour }] }, at the state that an address gives. */
    async open(board, state) {
      const [split, name] = board.key.split("/"), turn = ++this.turn;
      try {
        const index = await load(split).catch(() => null);
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
      const { index, board, colours, ui } = this, names = Object.keys(board.solvers);
      this.solvers = names.map((name) => ({ name, number: colours.get(name), shape: SHAPES[(colours.get(name) - 1) % SHAPES.length] }));
      const wanted = typeof state.solvers === "string" ? state.solvers.split(",") : state.solvers || [];
      const known = names.filter((name) => wanted.includes(name)).slice(0, MOST);
      const mean = (name) => board.solvers[name].dx.reduce((sum, value) => sum + Math.min(value ?? 0, board.caps.dx), 0);
      const best = [...names].sort((a, b) => mean(a) - mean(b)).slice(0, AT_FIRST);
      this.chosen = known.length ? known : names.filter((name) => best.includes(name));
      const number = Number(state.sequence ?? NaN);
      this.sequence = index.sequences.includes(number) ? number : this.sorted()[0];
      this.metric = Object.values(board.solvers).some(({ dx }) => dx.some((value) => value !== null)) ? "dx" : "dt";
      ui.metric.value = this.metric;
      this.sayGone(state.sequence, wanted.filter((name) => name && !names.includes(name)));
      list(ui.board, Object.keys(index.boards).map((name) => [name, name.replace(/-(?=[^-]*$)/, ", ")]), this.name);
      this.listSequences();
    }

    /** Numbers of the sequences, the largest mean Δx of the chosen solvers first. */
    sorted() {
      return [...this.index.sequences].sort((a, b) => this.errorOf(b) - this.errorOf(a) || a - b);
    }

    errorOf(sequence) {
      const place = this.index.sequences.indexOf(sequence), values = this.chosen.map((name) => this.board.solvers[name].dx[place] ?? 0);
      return values.reduce((sum, value) => sum + value, 0) / Math.max(1, values.length);
    }

    /** The list of sequences, each with its people, frames and error. */
    listSequences() {
      const { index, ui } = this, { sequences } = index, text = (sequence) => {
        const place = sequences.indexOf(sequence);
        return `${sequence} · Δx ${short(this.errorOf(sequence))} m · ${index.people[place]} people · ${index.frames[place]} frames`;
      };
      list(ui.sequence, this.sorted().map((sequence) => [sequence, text(sequence)]), this.sequence);
      const known = { relative: "; all as seen from the camera, Δx is Δx̃", poses: "; where people really are is not known" };
      const ends = sequences.length > 2 ? ", the best and the worst among them" : "";
      ui.facts.textContent = `${count(sequences.length, "sequence")} of ${index.split}${ends}${known[index.truth] || ""}`;
    }

    /** Load what is chosen, and go to a frame of it. */
    async show(frame) {
      const turn = ++this.turn, { index, name, board, sequence } = this;
      this.wanted = frame; // until it is loaded; the slider may want another by then
      try {
        const folder = `${index.split}/${board.tier}/${sequence}`;
        const clip = this.clip && this.folder === folder ? this.clip : await decodeClip(await load(folder));
        const estimates = await Promise.all(this.chosen.map(async (solver) => {
          const value = await load(`${index.split}/${name}/${sequence}/${solver}`);
          return addErrors(await decodeEstimate(value, clip), clip, board.given);
        }));
        if (turn === this.turn) this.begin(folder, clip, estimates);
      } catch (error) {
        if (turn === this.turn) this.refuse(error);
      }
    }

    begin(folder, clip, estimates) {
      const { ui, views, index, sequence } = this, fresh = clip !== this.clip;
      ui.note.hidden = true;
      ui.body.hidden = false;
      Object.assign(this, { folder, clip, estimates, moment: new Moment(clip, estimates) });
      if (fresh) {
        const pictures = `data/player/pictures/${encodeURIComponent(index.split)}/${sequence}`;
        views.ego.start(clip, index.pictures[sequence] || 0, (t) => `${pictures}/${String(t).padStart(5, "0")}.jpg`, () => this.ask());
        views.map.start(clip);
        this.pinned = this.hovered = -1;
        list(ui.person, [[-1, "nobody"], ...clip.tracks.map((track, k) => [k, track])], -1);
      }
      ui.scrub.max = clip.T - 1;
      this.recolour();
      this.go(Number(this.wanted ?? this.worst) || 0);
      this.wanted = null;
      this.moment.go(this.at, false, false);
      if (fresh) views.ego.turnTo(this.moment);
    }

    recolour() {
      if (!this.clip) return;
      this.theme = readTheme(this.ui.root, this.solvers.map(({ number }) => number), this.clip.colours, this.index.palette);
      for (const solver of this.solvers) solver.colour = this.theme.solvers.get(solver.number);
      this.drawn = this.solvers.filter((solver) => this.chosen.includes(solver.name));
      this.listSolvers();
      this.showCurves();
      this.last = -1;
      this.ask();
    }

    /** A row a solver: its check box with the mark it has on the map, and cells for its errors. */
    listSolvers() {
      const { ui, solvers, chosen } = this, held = ui.solvers.contains(document.activeElement) ? document.activeElement.value : null;
      ui.solvers.replaceChildren(...solvers.map((solver) => {
        const checked = chosen.includes(solver.name), onchange = ({ target }) => this.toggle(solver.name, target.checked);
        const box = make("input", { type: "checkbox", value: solver.name, onchange });
        Object.assign(box, { checked, disabled: !checked && chosen.length >= MOST });
        const mark = make("canvas", { width: 32, height: 32, class: "player-mark", "aria-hidden": "true" });
        const context = mark.getContext("2d");
        addMark(context, solver.shape, 16, 16, 10);
        Object.assign(context, { lineWidth: 4, strokeStyle: solver.colour }).stroke();
        solver.cells = ["dx", "dt", "mean"].map(() => make("td", {}));
        return make("tr", {}, make("th", { scope: "row" }, make("label", {}, box, mark, solver.name)), ...solver.cells);
      }));
      if (held !== null) ui.solvers.querySelector(`input[value="${CSS.escape(held)}"]`)?.focus();
    }

    showCurves() {
      const { views, drawn, estimates, metric, clip, theme, ui } = this, values = estimates.map((estimate) => estimate[metric]);
      const given = Array.from({ length: clip.T }, (_, t) => clip.tracks.some((_one, k) => this.isGiven(t, k)));
      this.worst = worstFrame(values, this.board.caps[metric]);
      views.strip.show(drawn.map(({ colour }, n) => ({ colour, values: values[n] })), given, this.worst, theme);
      ui.button("worst").disabled = this.worst < 0;
    }

    toggle(name, on) {
      const rest = this.chosen.filter((other) => other !== name), wanted = on && rest.length < MOST ? [...rest, name] : rest;
      this.chosen = Object.keys(this.board.solvers).filter((other) => wanted.includes(other));
      this.listSequences();
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
      const play = this.ui.button("play"), text = on ? "Pause" : "Play";
      Object.assign(play, { innerHTML: icon(text.toLowerCase()), title: text, ariaLabel: text });
      this.ask();
    }

    ask() {
      if (!this.waiting) this.waiting = requestAnimationFrame(this.tick);
    }

    tick = (now) => {
      this.waiting = 0;
      if (!this.clip || !this.ui.root.isConnected) return;
      if (this.playing) this.advance(now);
      this.draw();
      if (this.playing) this.ask();
    };

    advance(now) {
      const end = this.clip.T - 1, passed = this.before ? Math.min(now - this.before, 250) / 1000 : 0;
      this.before = now;
      this.at += (passed * this.speed) / this.clip.dt;
      if (this.at < end) return;
      this.at = end;
      this.play(false);
    }

    draw() {
      const { moment, views, theme, drawn } = this, selected = this.hovered >= 0 ? this.hovered : this.pinned;
      const options = { ids: this.ui.ids.checked, isGiven: this.isGiven, isAlarm: this.isAlarm, selected };
      moment.go(this.at, this.smooth && this.playing, views.ego.pictures);
      views.ego.draw(moment, theme, options);
      views.map.draw(moment, drawn, theme, options);
      views.strip.draw(this.at);
      if (moment.frame !== this.last || selected !== this.lastPerson || !this.playing) this.read(selected);
    }

    /** Write down the figures of the frame. */
    read(person) {
      const { ui, moment, clip, estimates, drawn, solvers, board } = this, t = moment.frame;
      Object.assign(this, { last: t, lastPerson: person });
      ui.scrub.value = t;
      ui.scrub.setAttribute("aria-valuetext", `frame ${t} of ${clip.T - 1}`);
      ui.clock.textContent = `${t} / ${clip.T - 1} · ${(t * clip.dt).toFixed(1)} s`;
      const place = this.index.sequences.indexOf(this.sequence);
      for (const { name, cells } of solvers) {
        const estimate = estimates[drawn.findIndex((solver) => solver.name === name)];
        const texts = [estimate ? short(estimate.dx[t]) : "", estimate ? short(estimate.dt[t]) : "", short(board.solvers[name].dx[place] ?? NaN)];
        cells.forEach((cell, n) => { cell.textContent = texts[n]; });
      }
      ui.personText.textContent = person >= 0 ? this.personText(person) : "Point at somebody, or choose.";
      this.sayBoxes();
      if (!this.playing) this.sayFrame();
    }

    /** A person's distance and errors in this frame. */
    personText(k) {
      const { moment, clip, drawn, estimates } = this, t = moment.frame, i = t * clip.K + k;
      const away = Math.hypot(clip.px[i] - clip.x[t], clip.py[i] - clip.y[t]).toFixed(1);
      if (this.isAlarm(t, k)) return `Box ${clip.tracks[k]} shows nobody: a false alarm, which is not scored.`;
      if (Number.isNaN(clip.px[i])) return `Person ${clip.tracks[k]} is not there in this frame.`;
      const errors = estimates.map(({ px: x, py: y }, n) => `${drawn[n].name} ${short(Math.hypot(x[i] - clip.px[i], y[i] - clip.py[i]))} m`);
      const state = this.isGiven(t, k) ? "; its position is given" : clip.observed[i] ? "" : "; no box";
      return `Person ${clip.tracks[k]}, ${away} m away${state}. Off by: ${errors.join(", ") || "no solver chosen"}.`;
    }

    /** How many boxes there are, each kind beside the mark that it has. */
    sayBoxes() {
      const { clip, moment, ui, board, index } = this, t = moment.frame;
      const boxes = clip.tracks.filter((_, k) => clip.observed[t * clip.K + k]).length;
      const alarms = clip.tracks.filter((_, k) => this.isAlarm(t, k)).length;
      const nobody = board.tier === "footage" || index.truth === "relative" ? "nobody whose place is known" : "nobody";
      const said = { boxes: count(boxes, "box", "boxes"), alarms: alarms && `${alarms} of them ${alarms === 1 ? "shows" : "show"} ${nobody}` };
      for (const [name, text] of Object.entries(said)) {
        const place = ui.boxesLine.querySelector(`[data-${name}]`);
        place.lastChild.textContent = text || "";
        place.hidden = !text;
      }
    }

    /** Say the frame's errors, and describe both views, for those who hear the page. */
    sayFrame() {
      const { ui, clip, moment, drawn, estimates, board } = this, t = moment.frame, names = drawn.map(({ name }) => name);
      const seen = clip.tracks.filter((_, k) => clip.observed[t * clip.K + k]).length;
      const errors = estimates.map(({ dx, dt }, n) => `${names[n]}: people off by ${short(dx[t])} m, camera by ${short(dt[t])} m`).join("; ");
      const words = t < START && board.given !== "origin" ? "everything is given" : t < START || !seen ? "nothing is scored" : errors;
      const said = `Frame ${t} of ${clip.T - 1}, ${seen} people seen${words && ": "}${words}.`;
      if (ui.said.textContent !== said) ui.said.textContent = said;
      ui.ego.ariaLabel = `Boxes of ${seen} people in ${clip.picture.round ? "the panorama around the observer" : "the observer's picture"}.`;
      ui.map.ariaLabel = `Map from above: the observer, the people around, and the estimates of ${names.join(", ") || "no solver"}.`;
    }

    /** Say what an address asks for that cannot be played here. */
    sayGone(sequence, solvers) {
      const isGone = sequence !== undefined && String(sequence) !== String(this.sequence);
      const gone = [isGone ? `Sequence ${sequence} cannot be played here; this is sequence ${this.sequence}.` : "",
        solvers.length ? `There is no solver ${solvers.join(", ")} on this board.` : ""].filter(Boolean);
      Object.assign(this.ui.gone, { textContent: gone.join(" "), hidden: !gone.length });
    }

    state() {
      return { sequence: this.sequence, frame: Math.round(this.at), solvers: this.chosen.join(",") };
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
      Object.assign(this, { playing: false, clip: null });
      this.ui.body.hidden = true;
      Object.assign(this.ui.note, { hidden: false, textContent: error.message });
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

  /* Controls and keys joined to the player, and how the page mounts it. */

  const ZOOM = 1.3, PAN = 60; // a press of a key
  const PLAIN = { " ": "play", ArrowLeft: "previous", ArrowRight: "next", Home: "start", End: "end" };
  const OTHER = { "+": "in", "=": "in", "-": "out", "−": "out", 0: "fit", w: "worst", i: "ids", "?": "help" };
  const SHIFTS = { ArrowLeft: [PAN, 0], ArrowRight: [-PAN, 0], ArrowUp: [0, PAN], ArrowDown: [0, -PAN] };

  const actions = {
    play: (s) => s.play(!s.playing),
    previous: (s) => jump(s, Math.round(s.at) - 1),
    next: (s) => jump(s, Math.round(s.at) + 1),
    start: (s) => jump(s, 0),
    end: (s) => jump(s, s.clip.T - 1),
    in: (s) => zoom(s, ZOOM),
    out: (s) => zoom(s, 1 / ZOOM),
    fit: (s) => { s.views.map.fitTruth(); s.ask(); },
    worst: (s) => jump(s, s.worst),
    ids: (s) => s.ui.ids.click(),
    help: (s) => s.ui.help.showModal(),
    link: copyLink,
  };

  function jump(s, frame) {
    if (s.playing) s.play(false);
    s.go(frame);
    s.tellSoon();
  }

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

  async function copyLink(s) {
    s.tell();
    const said = s.ui.button("link").querySelector("span"), say = (textContent, className) => Object.assign(said, { textContent, className });
    await navigator.clipboard.writeText(location.href).then(() => say("Copied", "said"), () => say("Copy the address above", "said"));
    setTimeout(() => say("Copy link", ""), 2500);
  }

  function pin(s, k) {
    Object.assign(s, { pinned: k, last: -1 });
    s.ui.person.value = k;
    s.ask();
  }

  function connect(s) {
    const { ui } = s, on = (name, event, act) => ui[name].addEventListener(event, () => act(ui[name].value));
    ui.root.addEventListener("click", (event) => {
      const name = event.target.closest("[data-do]")?.dataset.do;
      if (name && (s.clip || name === "help")) actions[name](s);
    });
    on("sequence", "change", (value) => pick(s, Number(value)));
    on("board", "change", (name) => { // another board of the split, the same sequence, frame and solvers
      s.tell(); // now, not when the other board is there
      location.hash = vbbench.address.format({ board: `${s.index.split}/${name}`, view: "play", options: s.state() });
    });
    on("ids", "change", () => s.ask());
    on("scrub", "input", (value) => jump(s, Number(value)));
    ui.speed.value = s.speed;
    on("speed", "change", (value) => { s.speed = Number(value); });
    on("metric", "change", (metric) => { s.metric = metric; if (s.clip) { s.showCurves(); s.ask(); } });
    on("person", "change", (value) => pin(s, Number(value)));
    connectViews(s);
    const keys = (event) => onKey(s, event), sizes = new ResizeObserver(() => s.ask());
    document.addEventListener("keydown", keys);
    for (const canvas of [ui.ego, ui.map, ui.strip]) sizes.observe(canvas);
    s.stops = [() => document.removeEventListener("keydown", keys), () => sizes.disconnect(), onTheme(() => s.recolour())];
  }

  function connectViews(s) {
    const { map, ego, strip } = s.views, handlers = (view) => ({
      hover: (x, y) => {
        const found = s.clip && x >= 0 ? view.pick(s.moment, x, y) : -1;
        if (found !== s.hovered) { s.hovered = found; s.ask(); }
      },
      click: (x, y) => pin(s, view.pick(s.moment, x, y)),
      zoom: (...how) => { view.zoom(...how); s.ask(); },
      pan: (...how) => { view.pan(...how); s.ask(); },
    });
    onView(s.ui.ego, handlers(ego));
    onMap(s.ui.map, handlers(map));
    onStrip(s.ui.strip, (x) => jump(s, strip.frameAt(x)));
  }

  function onKey(s, event) {
    if (!s.clip || s.ui.help.open || event.ctrlKey || event.metaKey || event.altKey) return;
    const { key, target } = event, busy = target.closest?.("input, select, textarea, button, a, summary");
    if (busy && (key in PLAIN || target.matches("select, textarea, input:not([type=checkbox], [type=range])"))) return;
    if (event.shiftKey && key in SHIFTS) { s.views.map.pan(...SHIFTS[key]); s.ask(); }
    else if (key in PLAIN) actions[PLAIN[key]](s);
    else if (key in OTHER) actions[OTHER[key]](s);
    else return;
    event.preventDefault();
  }

  const player = (vbbench.player = { session: null, decodeClip, decodeEstimate });

  /** Show the player in an element: { board, state: { sequence, frame, solvers }, onState(state) }. */
  player.mount = (element, wanted) => {
    player.unmount();
    player.session = new Session(element, wanted);
  };

  player.unmount = () => {
    player.session?.close();
    player.session = null;
  };
})();
