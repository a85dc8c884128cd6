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
