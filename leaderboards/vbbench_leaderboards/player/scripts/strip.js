/* The strip under the scrubber: error over time, a line a solver; a click goes there. */
"use strict";
(function (parts) {
  const LEFT = 34, RIGHT = 6, TOP = 8, BOTTOM = 14; // CSS px

  class Strip {
    constructor(canvas) {
      this.canvas = canvas;
      this.context = canvas.getContext("2d");
      this.still = document.createElement("canvas"); // all but the cursor
    }

    /** Curves are { colour, values [T] }; they are drawn once, until something changes. */
    show(curves, frames, theme) {
      Object.assign(this, { curves, frames, theme, stale: true });
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
      return height - BOTTOM * ratio - (value / this.top) * (height - (TOP + BOTTOM) * ratio);
    }

    /** Frame at a column of the canvas (CSS px). */
    frameAt(column) {
      const share = (column - LEFT) / (this.canvas.clientWidth - LEFT - RIGHT);
      return Math.round(Math.min(Math.max(share, 0), 1) * (this.frames - 1));
    }

    paint() {
      const { canvas, still, theme, frames, curves } = this, { ratio } = canvas;
      Object.assign(still, { width: canvas.width, height: canvas.height });
      const context = still.getContext("2d");
      const largest = Math.max(...curves.flatMap(({ values }) => Array.from(values).filter((v) => v === v)), 1e-3);
      this.top = ceiling(largest);
      context.fillStyle = theme.ink;
      context.globalAlpha = 0.07;
      context.fillRect(this.x(0), 0, this.x(Math.min(parts.START, frames) - 0.5) - this.x(0), this.y(0));
      context.globalAlpha = 1;
      context.fillStyle = theme.line;
      for (const share of [0, 0.5, 1]) {
        context.fillRect(LEFT * ratio, Math.round(this.y(share * this.top)), canvas.width - (LEFT + RIGHT) * ratio, 1);
      }
      this.letter(context, ratio);
      for (const { colour, values } of curves) this.curve(context, colour, values, ratio);
      this.stale = false;
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
      const every = [5, 10, 20, 50, 100, 200, 500].find((n) => this.frames / n <= 10) || 1000;
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
