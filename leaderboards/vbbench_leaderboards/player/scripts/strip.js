/* The strip under the scrubber: error over time, a line a solver; what is given, and the moments that tell most. */
"use strict";
(function (parts) {
  const LEFT = 34, RIGHT = 6, TOP = 14, BOTTOM = 19, TICK = 4; // CSS px
  const STEEP = 8; // a solver that is so many times worse than another is cut off at the top

  class Strip {
    constructor(canvas) {
      this.canvas = canvas;
      this.context = canvas.getContext("2d");
      this.still = document.createElement("canvas"); // all but the cursor
    }

    /** Curves are { colour, values [T] }, given [T] counts of given positions, moments are frames; drawn until a change. */
    show(curves, given, moments, theme) {
      Object.assign(this, { curves, given, moments, frames: given.length, theme, stale: true });
    }

    draw(at) {
      const { canvas, context } = this;
      if (parts.fit(canvas) || this.stale) this.paint();
      const { ratio } = canvas;
      context.setTransform(1, 0, 0, 1, 0, 0);
      context.clearRect(0, 0, canvas.width, canvas.height);
      context.drawImage(this.still, 0, 0);
      context.fillStyle = this.theme.accent;
      context.fillRect(this.x(at) - ratio, 0, 2 * ratio, canvas.height - BOTTOM * ratio);
      for (const { colour, values } of this.curves) {
        const value = values[Math.floor(at)];
        if (value !== value) continue;
        context.beginPath();
        context.arc(this.x(Math.floor(at)), this.y(value), 3 * ratio, 0, 2 * Math.PI);
        context.fillStyle = colour;
        context.fill();
      }
    }

    x(at) {
      const { ratio, width } = this.canvas;
      return LEFT * ratio + (at / Math.max(1, this.frames - 1)) * (width - (LEFT + RIGHT) * ratio);
    }

    y(value) {
      const { ratio, height } = this.canvas;
      return height - BOTTOM * ratio - (Math.min(value, 1.05 * this.top) / this.top) * (height - (TOP + BOTTOM) * ratio);
    }

    /** Frame at a column of the canvas (CSS px). */
    frameAt(column) {
      const share = (column - LEFT) / (this.canvas.clientWidth - LEFT - RIGHT);
      return Math.round(Math.min(Math.max(share, 0), 1) * (this.frames - 1));
    }

    paint() {
      const { canvas, still, theme, curves } = this, { ratio } = canvas;
      Object.assign(still, { width: canvas.width, height: canvas.height });
      const context = still.getContext("2d");
      const largest = curves.map(({ values }) => values.reduce((most, v) => (v > most ? v : most), 0)).filter((most) => most > 0);
      const least = Math.min(...largest), whole = Math.max(...largest, 1e-3);
      this.top = ceiling(whole > STEEP * least ? Math.max(2 * least, 1e-3) : whole);
      this.paintGiven(context, ratio);
      context.fillStyle = theme.line;
      for (const share of [0, 0.5, 1]) {
        context.fillRect(LEFT * ratio, Math.round(this.y(share * this.top)), canvas.width - (LEFT + RIGHT) * ratio, 1);
      }
      this.letter(context, ratio);
      if (curves.length === 2) this.paintBetween(context);
      for (const { colour, values } of curves) this.curve(context, colour, values, ratio);
      if (whole > 1.05 * this.top) this.paintCut(context, whole, ratio);
      this.paintMoments(context, ratio);
      this.stale = false;
    }

    /** A band where everything is given, and a tick under every frame in which somebody's position is. */
    paintGiven(context, ratio) {
      const { theme, given, frames } = this, low = this.y(0);
      context.fillStyle = theme.ink;
      context.globalAlpha = 0.07;
      context.fillRect(this.x(0), 0, this.x(Math.min(parts.START, frames) - 0.5) - this.x(0), low);
      context.globalAlpha = 0.55;
      const wide = Math.max(ratio, Math.min(3 * ratio, this.x(1) - this.x(0) - ratio));
      for (let t = 0; t < frames; t++) if (given[t]) context.fillRect(this.x(t) - wide / 2, low + ratio, wide, TICK * ratio);
      context.globalAlpha = 1;
    }

    /** The area between two lines, in the colour of the one with the larger error. */
    paintBetween(context) {
      const [first, second] = this.curves;
      context.globalAlpha = 0.16;
      for (let t = 1; t < this.frames; t++) {
        const [a, b, c, d] = [first.values[t - 1], first.values[t], second.values[t], second.values[t - 1]];
        if (!(a + b + c + d < Infinity)) continue;
        context.fillStyle = a + b > c + d ? first.colour : second.colour;
        context.beginPath();
        context.moveTo(this.x(t - 1), this.y(a)); context.lineTo(this.x(t), this.y(b));
        context.lineTo(this.x(t), this.y(c)); context.lineTo(this.x(t - 1), this.y(d));
        context.fill();
      }
      context.globalAlpha = 1;
    }

    /** Say how far a line goes that leaves the strip at its top. */
    paintCut(context, whole, ratio) {
      context.font = `${10 * ratio}px ${parts.FONT}`;
      context.textAlign = "right";
      context.textBaseline = "middle";
      const text = `↑ up to ${parts.short(whole)}`, x = this.canvas.width - (RIGHT + 2) * ratio;
      parts.label(context, text, x, this.y(this.top) + 8 * ratio, this.theme.ink, this.theme.paper);
    }

    paintMoments(context, ratio) {
      context.fillStyle = this.theme.accent;
      this.moments.forEach((t, n) => {
        const x = this.x(t), size = (n ? 3.5 : 5) * ratio;
        context.beginPath();
        context.moveTo(x - size, ratio); context.lineTo(x + size, ratio); context.lineTo(x, ratio + 1.5 * size);
        context.globalAlpha = n ? 0.6 : 1;
        context.fill();
      });
      context.globalAlpha = 1;
    }

    letter(context, ratio) {
      context.fillStyle = this.theme.faint;
      context.font = `${10 * ratio}px ${parts.FONT}`;
      context.textAlign = "right";
      context.textBaseline = "middle";
      for (const share of [0, 0.5, 1]) {
        context.fillText(String(+(share * this.top).toPrecision(3)), (LEFT - 5) * ratio, this.y(share * this.top));
      }
      context.textAlign = "center";
      context.textBaseline = "bottom";
      const every = [1, 2, 5, 10, 20, 50, 100, 200, 500].find((n) => this.frames / n <= 10) || 1000;
      for (let t = 0; t < this.frames; t += every) context.fillText(t, this.x(t), this.canvas.height);
    }

    curve(context, colour, values, ratio) {
      context.beginPath();
      let drawn = false;
      values.forEach((value, t) => {
        if (value === value) context[drawn ? "lineTo" : "moveTo"](this.x(t), this.y(value));
        drawn = value === value;
      });
      context.lineWidth = 1.6 * ratio;
      context.strokeStyle = colour;
      context.stroke();
    }
  }

  /** The next round number. */
  function ceiling(value) {
    const decade = 10 ** Math.floor(Math.log10(value));
    return decade * [1, 1.5, 2, 3, 4, 6, 8, 10].find((step) => step * decade >= value * 0.999);
  }

  Object.assign(parts, { Strip });
})(vbbench.player.parts);
