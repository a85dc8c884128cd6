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
