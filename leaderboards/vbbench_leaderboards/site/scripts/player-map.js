/* Where everybody came from: drawn once a frame into a layer of its own, which moves with the map. */
"use strict";
(function (parts) {
  const SECONDS = 4;
  const POINTS = 3000; // a crowd's trails are shorter, so that they take no longer
  const FASTEST = 6; // m/s; where somebody true is faster, a track went over to somebody else
  const MARGIN = 96; // device px around the canvas, so that a following camera need not draw anew at once
  const TRUE = { alpha: 0.28, width: 1.5 }, GUESSED = { alpha: 0.6, width: 1.2 };

  class Trails {
    constructor() {
      this.layer = document.createElement("canvas");
      this.context = this.layer.getContext("2d");
    }

    /** Draw the trails of a moment onto a map whose place (`ox`, `oy`, `k`) is set. */
    draw(map, moment, solvers, theme) {
      if (this.isStale(map, moment, solvers, theme)) this.paint(map, moment, solvers, theme);
      map.context.drawImage(this.layer, Math.round(map.ox - this.ox) - MARGIN, Math.round(map.oy - this.oy) - MARGIN);
      this.each(moment, solvers, theme, (room, look) => this.drawEnds(map, moment, room, look));
    }

    isStale(map, moment, solvers, theme) {
      const moved = Math.max(Math.abs(map.ox - this.ox), Math.abs(map.oy - this.oy));
      return !(moved <= MARGIN && this.k === map.k && this.frame === moment.frame && this.moment === moment &&
        this.theme === theme && this.solvers === solvers && this.others === moment.others && this.layer.width === map.canvas.width + 2 * MARGIN &&
        this.layer.height === map.canvas.height + 2 * MARGIN);
    }

    paint(map, moment, solvers, theme) {
      const { ox, oy, k, canvas } = map, { layer, context } = this;
      Object.assign(this, { ox, oy, k, moment, frame: moment.frame, others: moment.others, solvers, theme });
      const width = canvas.width + 2 * MARGIN, height = canvas.height + 2 * MARGIN;
      if (layer.width !== width || layer.height !== height) Object.assign(layer, { width, height });
      else context.clearRect(0, 0, width, height);
      context.lineJoin = "bevel";
      this.each(moment, solvers, theme, (room, look) => this.paintPaths(map, moment, room, look));
    }

    /** Call back with the truth's room and every solver's, and how its trails look. */
    each(moment, solvers, theme, draw) {
      draw(moment.truth, { ...TRUE, colour: theme.ink });
      for (let n = 0; n < moment.estimates.length; n++) draw(moment.estimates[n], { ...GUESSED, colour: solvers[n].colour });
    }

    /** Past frames of those who are there, and of the observer. */
    paintPaths(map, moment, { source }, look) {
      const { context } = this, truly = source === map.clip, { K, dt } = map.clip, { frame } = moment;
      const from = Math.max(0, frame - Math.min(Math.round(SECONDS / dt), Math.ceil(POINTS / K)));
      style(context, look, map.canvas.ratio);
      const x = (value) => this.ox + MARGIN + value * this.k, y = (value) => this.oy + MARGIN - value * this.k;
      for (let k = 0; k < K; k++) {
        if (source.px[frame * K + k] !== source.px[frame * K + k] || !moment.isShown(k)) continue;
        context.beginPath();
        let drawn = false;
        for (let t = from, i = from * K + k; t <= frame; t++, i += K) {
          const there = source.px[i] === source.px[i];
          if (there && drawn && !(truly && Math.hypot(source.px[i] - source.px[i - K], source.py[i] - source.py[i - K]) > FASTEST * dt)) context.lineTo(x(source.px[i]), y(source.py[i]));
          else if (there) context.moveTo(x(source.px[i]), y(source.py[i]));
          drawn = there;
        }
        context.stroke();
      }
      context.beginPath();
      for (let t = from; t <= frame; t++) context.lineTo(x(source.x[t]), y(source.y[t]));
      context.stroke();
    }

    /** From the last frame to where everybody is between two. */
    drawEnds(map, moment, room, look) {
      if (!map.between) return;
      const { frame } = moment;
      const { context } = map, { K } = map.clip, { source } = room;
      style(context, look, map.canvas.ratio);
      context.beginPath();
      for (let k = 0, i = frame * K; k < K; k++, i++) {
        if (source.px[i] !== source.px[i] || room.px[k] !== room.px[k] || !moment.isShown(k)) continue;
        context.moveTo(map.sx(source.px[i]), map.sy(source.py[i]));
        context.lineTo(map.sx(room.px[k]), map.sy(room.py[k]));
      }
      context.moveTo(map.sx(source.x[frame]), map.sy(source.y[frame]));
      context.lineTo(map.sx(room.x), map.sy(room.y));
      context.stroke();
      context.globalAlpha = 1;
    }
  }

  function style(context, { alpha, width, colour }, ratio) {
    context.globalAlpha = alpha;
    context.lineWidth = width * ratio;
    context.strokeStyle = colour;
  }

  Object.assign(parts, { Trails });
})(vbbench.player.parts);
/* The map from above: true people and camera, up to three solvers' estimates, trails, error lines, a metric grid. */
"use strict";
(function (parts) {
  const PERSON = 0.22; // radius of a person in m
  const STEPS = [0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1e3, 2e3, 5e3, 1e4, 1e5];
  const MARGIN = 1.5; // m around the crowd
  const REACH = 15; // m around the camera's way, where nobody's place is known

  class MapView {
    constructor(canvas) {
      this.canvas = canvas;
      this.context = canvas.getContext("2d");
      this.view = { x: 0, y: 0, scale: 40 }; // centre in m, CSS px a metre
      this.legend = canvas.parentElement.querySelector(".player-legend");
      this.trails = new parts.Trails();
      this.below = 0; // CSS px at the bottom, under the legend
      this.home = true; // still as `fitTruth` left it
      this.following = false; // when it is true, the centre is counted from the camera
    }

    start(clip) {
      this.clip = clip;
      this.home = true;
    }

    /** Look at all who are ever seen, where they truly are; where that is not known, at what is around the camera's way. */
    fitTruth() {
      const { clip } = this, known = clip.known.some((one) => one), around = known ? MARGIN : REACH;
      const seen = (values) => values.filter((_, i) => clip.observed[i]);
      const [left, right] = extent(seen(clip.px), clip.x), [low, high] = extent(seen(clip.py), clip.y);
      this.look([left - around, right + around], [low - around, high + around]);
      this.home = true;
    }

    /** Look at all that is there at a moment, however far off the estimates are. */
    fitAll(moment) {
      const { truth, estimates, others } = moment, shown = (_, n) => moment.isShown(n);
      const places = (name, own) => [...truth[name].filter(shown), ...(others?.[name] || []), truth[own],
        ...estimates.flatMap((room) => [...room[name], room[own]])];
      const [left, right] = extent(places("px", "x"), []), [low, high] = extent(places("py", "y"), []);
      const around = MARGIN + 0.08 * Math.max(right - left, high - low);
      this.look([left - around, right + around], [low - around, high + around], this.following ? truth : { x: 0, y: 0 });
      this.home = false;
    }

    look([left, right], [low, high], from = null) {
      const { canvas, view } = this, still = this.following && !from;
      view.x = still ? 0 : (left + right) / 2 - (from?.x || 0);
      view.y = still ? 0 : (low + high) / 2 - (from?.y || 0);
      view.scale = Math.min(canvas.clientWidth / (right - left), (canvas.clientHeight - this.below) / (high - low)) || 40;
      view.y -= this.below / 2 / view.scale; // above the legend
    }

    /** Keep the camera in the middle, or the world where it is. */
    follow(on, { x, y }) {
      this.following = on;
      this.view.x = on ? 0 : this.view.x + x;
      this.view.y = on ? 0 : this.view.y + y;
      this.home = false;
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
      const { context, canvas, view } = this;
      const resized = parts.fit(canvas);
      if (resized || this.fresh !== this.clip) {
        this.below = this.legend.offsetHeight + 14;
        if (this.home) this.fitTruth();
        this.fresh = this.clip;
      }
      const { ratio } = canvas;
      this.k = view.scale * ratio;
      this.ox = canvas.width / 2 - (view.x + (this.following ? moment.truth.x : 0)) * this.k;
      this.oy = canvas.height / 2 + (view.y + (this.following ? moment.truth.y : 0)) * this.k;
      context.setTransform(1, 0, 0, 1, 0, 0);
      context.fillStyle = theme.paper;
      context.fillRect(0, 0, canvas.width, canvas.height);
      this.between = moment.share > 0;
      this.drawGrid(theme);
      this.drawSight(moment, theme);
      if (options.trails) this.trails.draw(this, moment, solvers, theme);
      if (options.unboxed && moment.others) this.drawUnboxed(moment, theme);
      this.drawPeople(moment, theme, options);
      moment.estimates.forEach((room, n) => this.drawEstimate(moment, room, solvers[n], options));
      this.drawCamera(moment.truth, theme.ink, theme.paper);
      if (options.selected >= 0) this.drawSelected(moment, theme, options.selected);
      else if (options.ids) this.drawIds(moment, theme);
      this.drawEdges(moment, solvers, theme, options);
      this.drawScale(theme);
    }

    drawGrid(theme) {
      const { context, canvas, k, ox, oy } = this, { ratio } = canvas;
      const step = STEPS.find((metres) => metres * k >= 48 * ratio) || 1e6;
      context.lineWidth = Math.max(1, Math.round(ratio / 2));
      context.strokeStyle = theme.line;
      context.font = `${10 * ratio}px ${parts.FONT}`;
      this.step = step;
      const columns = this.marks(0, -ox / k, (canvas.width - ox) / k), rows = this.marks(1, (oy - canvas.height) / k, oy / k);
      context.beginPath();
      for (const [place] of columns) {
        const x = Math.round(ox + place * k) + 0.5;
        context.moveTo(x, 0); context.lineTo(x, canvas.height);
      }
      for (const [place] of rows) {
        const y = Math.round(oy - place * k) + 0.5;
        context.moveTo(0, y); context.lineTo(canvas.width, y);
      }
      context.globalAlpha = 0.7;
      context.stroke();
      context.globalAlpha = 1;
      context.fillStyle = theme.faint;
      context.textAlign = "left"; context.textBaseline = "top";
      for (const [place, text] of columns) context.fillText(text, ox + place * k + 3 * ratio, 3 * ratio);
      context.textBaseline = "bottom";
      for (const [place, text] of rows) {
        if (oy - place * k > 26 * ratio) context.fillText(text, 3 * ratio, oy - place * k - 2 * ratio);
      }
    }

    /** Places of the grid's lines on an axis, each with its coordinate in the scene, a multiple of the step. */
    marks(axis, low, high) {
      const { step } = this, shift = this.clip.origin[axis], found = [];
      for (let n = Math.ceil((low + shift) / step); n * step <= high + shift; n++) {
        found.push([n * step - shift, String(+(n * step).toFixed(1))]);
      }
      return found;
    }

    drawSight(moment, theme) {
      const { context, k } = this, { round, view } = this.clip.picture, { x, y, yaw } = moment.truth;
      const [left, right] = view || [-0.35, 0.35], reach = (round ? 2.2 : 12) * k;
      context.fillStyle = context.strokeStyle = theme.accent;
      context.beginPath();
      context.moveTo(this.sx(x), this.sy(y));
      context.arc(this.sx(x), this.sy(y), reach, -yaw + left, -yaw + right);
      context.closePath();
      context.globalAlpha = 0.12;
      context.fill();
      if (round) {
        context.beginPath();
        context.arc(this.sx(x), this.sy(y), reach, 0, 2 * Math.PI);
        context.globalAlpha = 0.4;
        context.lineWidth = this.canvas.ratio;
        context.stroke();
      }
      context.globalAlpha = 1;
    }

    drawPeople(moment, theme, options) {
      const { context, clip, canvas, k } = this, { px, py } = moment.truth;
      const radius = Math.max(PERSON * k, 2.5 * canvas.ratio), base = moment.frame * clip.K;
      for (let n = 0; n < clip.K; n++) {
        if (px[n] !== px[n] || !moment.isShown(n)) continue;
        context.beginPath();
        context.arc(this.sx(px[n]), this.sy(py[n]), radius, 0, 2 * Math.PI);
        context.fillStyle = theme.people[n];
        context.globalAlpha = clip.observed[base + n] ? 1 : 0.3;
        context.fill();
      }
      context.globalAlpha = 1;
      context.beginPath();
      for (let n = 0; n < clip.K; n++) {
        if (!options.isGiven(moment.frame, n) || px[n] !== px[n]) continue;
        const x = this.sx(px[n]), y = this.sy(py[n]), r = radius + 3 * canvas.ratio;
        context.moveTo(x + r, y);
        context.arc(x, y, r, 0, 2 * Math.PI);
      }
      context.lineWidth = 1.2 * canvas.ratio;
      context.strokeStyle = theme.ink;
      context.stroke();
    }

    /** People without a box: hollow, in their colour if they have one elsewhere in the sequence. */
    drawUnboxed({ others }, theme) {
      const { context, clip, canvas, k } = this, radius = Math.max(0.8 * PERSON * k, 2.2 * canvas.ratio);
      context.lineWidth = 1.3 * canvas.ratio;
      for (let n = 0; n < others.N; n++) {
        if (!others.reason(n) || others.px[n] !== others.px[n]) continue;
        context.beginPath();
        context.arc(this.sx(others.px[n]), this.sy(others.py[n]), radius, 0, 2 * Math.PI);
        context.strokeStyle = n < clip.K ? theme.people[n] : theme.faint;
        context.globalAlpha = 0.75;
        context.stroke();
      }
      context.globalAlpha = 1;
    }

    drawEstimate(moment, room, solver, options) {
      const { context, canvas, clip, k } = this, { truth } = moment;
      const radius = Math.max(0.8 * PERSON * k, 3.2 * canvas.ratio);
      context.strokeStyle = solver.colour;
      if (options.errors) {
        context.beginPath();
        for (let n = 0; n < clip.K; n++) {
          if (room.px[n] !== room.px[n] || truth.px[n] !== truth.px[n] || !moment.isShown(n)) continue;
          context.moveTo(this.sx(truth.px[n]), this.sy(truth.py[n]));
          context.lineTo(this.sx(room.px[n]), this.sy(room.py[n]));
        }
        context.moveTo(this.sx(truth.x), this.sy(truth.y));
        context.lineTo(this.sx(room.x), this.sy(room.y));
        context.lineWidth = 1.6 * canvas.ratio;
        context.stroke();
      }
      const stamp = this.stamp(solver, radius), half = stamp.width / 2;
      for (let n = 0; n < clip.K; n++) {
        if (room.px[n] === room.px[n] && !options.isGiven(moment.frame, n)) {
          context.drawImage(stamp, Math.round(this.sx(room.px[n]) - half), Math.round(this.sy(room.py[n]) - half));
        }
      }
      this.drawCamera(room, solver.colour, null);
    }

    /** A solver's mark, drawn once for a size: thousands of them are stamped in a picture. */
    stamp(solver, radius) {
      if (solver.radius === radius && solver.stamp) return solver.stamp;
      const stamp = document.createElement("canvas"), half = Math.ceil(1.3 * radius + 2 * this.canvas.ratio);
      stamp.width = stamp.height = 2 * half;
      const context = stamp.getContext("2d");
      parts.addShape(context, solver.shape, half, half, radius);
      context.lineWidth = 1.6 * this.canvas.ratio;
      context.strokeStyle = solver.colour;
      context.stroke();
      Object.assign(solver, { stamp, radius });
      return stamp;
    }

    /** An arrowhead that looks where the observer looks. */
    drawCamera(place, colour, rim) {
      const { context, canvas, k } = this, size = Math.max(0.34 * k, 8 * canvas.ratio);
      if (place.x !== place.x) return;
      const x = this.sx(place.x), y = this.sy(place.y);
      context.beginPath();
      for (const [turn, reach] of [[0, 1.15], [2.45, 1], [Math.PI, 0.35], [-2.45, 1]]) {
        context.lineTo(x + size * reach * Math.cos(place.yaw + turn), y - size * reach * Math.sin(place.yaw + turn));
      }
      context.closePath();
      context.lineWidth = 2 * canvas.ratio;
      context.strokeStyle = rim || colour;
      context.stroke();
      if (rim) { context.fillStyle = colour; context.fill(); }
    }
  }

  function extent(places, own) {
    let low = Infinity, high = -Infinity;
    for (const values of [places, own]) {
      for (const value of values) {
        if (value < low) low = value;
        if (value > high) high = value;
      }
    }
    return [low, high];
  }

  Object.assign(parts, { MapView });
})(vbbench.player.parts);
/* What lies outside the map: an arrow at its edge, with how far it is off; people who lie in one direction share one. */
"use strict";
(function (parts) {
  const STEP = 15, SIZE = 7, SECTORS = 20; // CSS px; directions that people are gathered in
  const INSET = { left: 12, right: 12, top: 24 }; // below the grid's figures; arrows below are above the legend
  const BUTTONS = { wide: 52, high: 190 }; // in the upper right corner

  const far = (metres) => (metres >= 1000 ? `${+(metres / 1000).toPrecision(2)} km` : `${+metres.toPrecision(2)} m`);

  /** Those of an estimate that are outside, by where their error lines leave the map: { at, turn, count, off, own }. */
  function gather(map, moment, room, isGiven, more) {
    const { canvas, clip } = map, { truth } = moment, found = new Map();
    const add = (x, y, tx, ty, camera) => {
      const sx = map.sx(x), sy = map.sy(y), slack = 4 * canvas.ratio;
      if (sx >= -slack && sy >= -slack && sx <= canvas.width + slack && sy <= canvas.height + slack) return;
      const { at, turn } = map.exit([map.sx(tx), map.sy(ty)], [sx, sy], more), off = Math.hypot(x - tx, y - ty);
      const side = Math.atan2(at[1] - canvas.height / 2, at[0] - canvas.width / 2) / (2 * Math.PI);
      const sector = Math.round((side + 1) * SECTORS) % SECTORS, one = found.get(sector) || { at, turn, count: 0, off: 0, own: NaN };
      if (camera) one.own = off;
      else { one.count += 1; one.off = Math.max(one.off, off); }
      found.set(sector, one);
    };
    if (room.x === room.x) add(room.x, room.y, truth.x, truth.y, true);
    for (let n = 0; n < clip.K; n++) {
      if (room.px[n] !== room.px[n] || isGiven(moment.frame, n)) continue;
      const known = truth.px[n] === truth.px[n];
      add(room.px[n], room.py[n], known ? truth.px[n] : truth.x, known ? truth.py[n] : truth.y, false);
    }
    return found;
  }

  /** Text of an arrow: the camera's error first, then how many people and the largest error of theirs. */
  function words({ count, off, own }) {
    const people = count ? `${count} ${count === 1 ? "person" : "people"} ${count > 1 ? "≤ " : ""}${far(off)}` : "";
    return [own === own ? `camera ${far(own)}` : "", people].filter(Boolean).join(", ");
  }

  Object.assign(parts.MapView.prototype, {
    /** Draw the arrows of every solver, each on a line of its own; how many things they stand for is kept in `outside`. */
    drawEdges(moment, solvers, theme, options) {
      const taken = [];
      this.outside = solvers.map(() => []);
      moment.estimates.forEach((room, n) => {
        for (const one of gather(this, moment, room, options.isGiven, STEP * n).values()) {
          this.outside[n].push(words(one));
          this.drawArrow(one, solvers[n].colour, theme, taken);
        }
      });
    },

    drawArrow(one, colour, theme, taken) {
      const { context, canvas } = this, { ratio } = canvas, size = SIZE * ratio;
      const dx = Math.cos(one.turn), dy = Math.sin(one.turn), [x, y] = one.at;
      context.beginPath();
      for (const [along, across] of [[1, 0], [-0.8, 0.85], [-0.8, -0.85]]) {
        context.lineTo(x + size * (along * dx - across * dy), y + size * (along * dy + across * dx));
      }
      context.closePath();
      context.lineWidth = 1.6 * ratio;
      context.strokeStyle = context.fillStyle = colour;
      context.stroke();
      if (one.own === one.own) context.fill();
      this.drawDistance(words(one), [x - 2.4 * size * dx, y - 2.4 * size * dy], dx, colour, theme.paper, taken);
    },

    /** Where the line from a place of the canvas to one outside leaves it, `more` CSS px further in than usual. */
    exit(from, to, more) {
      const { width, height, ratio } = this.canvas, inset = (side) => ((INSET[side] || this.below) + more) * ratio;
      const low = [inset("left"), inset("top")], high = [width - inset("right"), height - inset("bottom")];
      const inside = from.every((place, axis) => place > low[axis] && place < high[axis]);
      const [x, y] = inside ? from : [width / 2, height / 2], dx = to[0] - x, dy = to[1] - y;
      const reach = Math.min((dx > 0 ? high[0] - x : low[0] - x) / dx || Infinity, (dy > 0 ? high[1] - y : low[1] - y) / dy || Infinity);
      const row = y + reach * dy, right = width - (row < BUTTONS.high * ratio ? BUTTONS.wide + more : 0) * ratio;
      return { at: [Math.min(x + reach * dx, right), row], turn: Math.atan2(dy, dx) };
    },

    /** Beside an arrow, inwards, where no other such text stands; without room there is none. */
    drawDistance(text, [x, y], dx, colour, paper, taken) {
      const { context, canvas } = this, { ratio } = canvas, high = 14 * ratio;
      context.font = `${11 * ratio}px ${parts.FONT}`;
      const wide = context.measureText(text).width, away = 6 * ratio;
      const left = Math.min(Math.max(dx > 0.4 ? x - wide : dx < -0.4 ? x : x - wide / 2, away), canvas.width - wide - away);
      for (const shift of [0, 1, -1, 2, -2, 3, -3]) {
        const row = Math.min(Math.max(y + shift * high, INSET.top * ratio), canvas.height - this.below * ratio);
        if (taken.some((one) => Math.abs(one.row - row) < high && left < one.right && left + wide > one.left)) continue;
        taken.push({ row, left: left - away, right: left + wide + away });
        context.textAlign = "left";
        context.textBaseline = "middle";
        parts.label(context, text, left, row, colour, paper);
        return;
      }
    },
  });
})(vbbench.player.parts);
