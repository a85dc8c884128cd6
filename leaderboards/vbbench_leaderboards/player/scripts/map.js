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
