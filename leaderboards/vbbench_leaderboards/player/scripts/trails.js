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
