/* Colours, from the page's custom properties; shapes of solvers; canvases as sharp as the screen. */
"use strict";
(function (parts) {
  const FALLBACK = { ink: "#1b1f24", paper: "#ffffff", faint: "#6b7280", line: "#d7dbe0", accent: "#0b62c4", warn: "#8a5a00" };
  const SHAPES = ["square", "triangle", "diamond", "kite", "plus", "cross", "pentagon", "hexagon"];

  /** The colours of now; `people` [K] are those of a palette { light, dark } that the slots [K] name. */
  function readTheme(slots, palette) {
    const style = getComputedStyle(document.documentElement);
    const read = (name, other) => style.getPropertyValue(name).trim() || other;
    const theme = {};
    for (const name of Object.keys(FALLBACK)) theme[name] = read(`--${name}`, FALLBACK[name]);
    theme.dark = luminance(theme.paper) < 0.4;
    theme.solver = (k) => read(`--solver-${k}`, `hsl(${(k * 97) % 360} 70% ${theme.dark ? 65 : 40}%)`);
    theme.people = slots.map((slot) => palette[theme.dark ? "dark" : "light"][slot]);
    return theme;
  }

  function luminance(colour) {
    const context = document.createElement("canvas").getContext("2d");
    context.fillStyle = colour;
    context.fillRect(0, 0, 1, 1);
    const [red, green, blue] = context.getImageData(0, 0, 1, 1).data;
    return (0.3 * red + 0.6 * green + 0.1 * blue) / 255;
  }

  /** Call back whenever the page turns dark or light; returns how to stop. */
  function onTheme(changed) {
    const observer = new MutationObserver(changed);
    observer.observe(document.documentElement, { attributes: true, attributeFilter: ["data-theme", "class"] });
    const media = matchMedia("(prefers-color-scheme: dark)");
    media.addEventListener("change", changed);
    return () => { observer.disconnect(); media.removeEventListener("change", changed); };
  }

  const polygon = (path, x, y, r, corners, turn) => {
    for (let i = 0; i <= corners; i++) {
      const angle = turn + (2 * Math.PI * i) / corners;
      path[i ? "lineTo" : "moveTo"](x + r * Math.cos(angle), y + r * Math.sin(angle));
    }
  };

  /** Add a solver's mark to a path, or to a canvas' current one. */
  function addShape(path, shape, x, y, r) {
    switch (shape) {
      case "square": path.rect(x - 0.85 * r, y - 0.85 * r, 1.7 * r, 1.7 * r); break;
      case "triangle": polygon(path, x, y, 1.2 * r, 3, -Math.PI / 2); break;
      case "diamond": polygon(path, x, y, 1.2 * r, 4, 0); break;
      case "kite": polygon(path, x, y, 1.2 * r, 3, Math.PI / 2); break;
      case "pentagon": polygon(path, x, y, 1.1 * r, 5, -Math.PI / 2); break;
      case "hexagon": polygon(path, x, y, 1.1 * r, 6, 0); break;
      default: {
        const d = shape === "plus" ? [r, 0, 0, r] : [0.8 * r, 0.8 * r, -0.8 * r, 0.8 * r];
        path.moveTo(x - d[0], y - d[1]); path.lineTo(x + d[0], y + d[1]);
        path.moveTo(x - d[2], y - d[3]); path.lineTo(x + d[2], y + d[3]);
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

  const FONT = "system-ui, sans-serif";

  /** Text with a halo of paper, readable on anything. */
  function label(context, text, x, y, colour, halo) {
    context.lineWidth = 3;
    context.lineJoin = "round";
    context.strokeStyle = halo;
    context.strokeText(text, x, y);
    context.fillStyle = colour;
    context.fillText(text, x, y);
  }

  Object.assign(parts, { readTheme, onTheme, addShape, SHAPES, fit, label, FONT });
})(vbbench.player.parts);
/* What the observer sees: boxes on a strip of the panorama, or in the picture of a camera with borders. */
"use strict";
(function (parts) {
  const ASPECT = 0.38; // width of a person's box over its height
  const FILL = 0.22, FILL_ON_PICTURE = 0.1; // opacity
  const SMALL = 6; // half the width in CSS px under which boxes have corners
  const MARKS = [["back", 0], ["left", 0.25], ["ahead", 0.5], ["right", 0.75], ["back", 1]];

  /** Picture shown behind the boxes, loaded when first asked for. */
  class Pictures {
    constructor(folder, count, loaded) {
      Object.assign(this, { folder, count, loaded, images: [] });
    }

    of(frame) {
      for (let t = frame; t < Math.min(frame + 4, this.count); t++) {
        if (this.images[t]) continue;
        const image = (this.images[t] = new Image());
        image.onload = this.loaded;
        image.src = `${this.folder}/${String(t).padStart(5, "0")}.jpg`;
      }
      const image = this.images[frame];
      return image && image.complete && image.naturalWidth ? image : null;
    }
  }

  class EgoView {
    constructor(canvas) {
      this.canvas = canvas;
      this.context = canvas.getContext("2d");
      this.order = [];
    }

    /** Begin a clip: the shape of the view follows its camera. */
    start(clip, pictures) {
      this.clip = clip;
      this.pictures = pictures;
      this.shown = clip.picture; // rows and columns in px of the camera, as site/clip.py chose them
      this.order = Array.from({ length: clip.K }, (_, k) => k);
      this.canvas.style.aspectRatio = `${this.shown.width} / ${this.shown.height}`;
      this.canvas.style.setProperty("--aspect", this.shown.width / this.shown.height);
      const around = this.canvas.parentElement;
      around.classList.toggle("player-round", clip.picture.round);
    }

    /** On a narrow screen, move the panorama to where most boxes of a moment are; straight ahead if there are none. */
    turnTo({ boxes }) {
      const around = this.canvas.parentElement, wide = around.clientWidth, rate = this.canvas.clientWidth / this.shown.width;
      const places = boxes.u.filter((u) => u === u).map((u) => u * rate);
      let best = this.canvas.clientWidth / 2, most = 0;
      for (const place of places) {
        const count = places.filter((other) => Math.abs(other - place) < 0.45 * wide).length;
        if (count > most) { most = count; best = place; }
      }
      around.scrollLeft = best - wide / 2;
    }

    draw(moment, theme, options) {
      const { context, canvas, clip, shown } = this;
      parts.fit(canvas);
      const scale = canvas.width / shown.width;
      this.scale = scale;
      context.setTransform(1, 0, 0, 1, 0, 0);
      context.fillStyle = theme.paper;
      context.fillRect(0, 0, canvas.width, canvas.height);
      this.drawGround(moment, theme);
      context.setTransform(scale, 0, 0, scale, 0, -shown.top * scale);
      if (options.unboxed && moment.others) this.drawUnboxed(moment.others, theme, scale);
      this.order.sort((a, b) => (moment.boxes.l[a] || 0) - (moment.boxes.l[b] || 0));
      for (const k of this.order) this.drawBox(moment, k, theme, scale, options);
      if (clip.picture.round) this.drawCompass(theme);
      if (options.selected >= 0) this.drawSelected(moment, theme, options);
      else if (options.ids) this.drawIds(moment, theme);
    }

    drawGround(moment, theme) {
      const { context, canvas, shown, scale } = this;
      const picture = this.pictures && this.pictures.of(moment.frame);
      if (picture) {
        const rate = picture.naturalWidth / shown.width;
        context.drawImage(picture, 0, shown.top * rate, shown.width * rate, shown.height * rate,
          0, 0, canvas.width, canvas.height);
        return;
      }
      const rows = shown.horizon.map((row) => (row - shown.top) * scale);
      const level = rows.every((row) => row === rows[0]), at = (row) => (level ? Math.round(row) : row);
      const thick = Math.max(1, canvas.ratio);
      context.fillStyle = theme.ink;
      this.fillBelow(rows, rows.map(() => canvas.height), 0.06);
      context.fillStyle = theme.line;
      this.fillBelow(rows.map(at), rows.map((row) => at(row) + thick), 1);
    }

    /** Fill the canvas between two lines, given by their rows at columns evenly from border to border. */
    fillBelow(rows, bottoms, alpha) {
      const { context, canvas } = this, step = canvas.width / (rows.length - 1);
      context.globalAlpha = alpha;
      context.beginPath();
      rows.forEach((row, n) => context.lineTo(n * step, row));
      bottoms.forEach((_, n) => context.lineTo(canvas.width - n * step, bottoms[bottoms.length - 1 - n]));
      context.fill();
      context.globalAlpha = 1;
    }

    drawBox(moment, k, theme, scale, options) {
      const { u, v, l } = moment.boxes;
      if (l[k] !== l[k]) return;
      const { context, clip } = this, { round, width } = clip.picture, half = 0.5 * ASPECT * l[k], thin = this.canvas.ratio / scale;
      const copies = round && (u[k] < half || u[k] > width - half) ? 2 : 1;
      for (let copy = 0; copy < copies; copy++) {
        const centre = copy ? u[k] + (u[k] < half ? 1 : -1) * width : u[k];
        context.fillStyle = context.strokeStyle = theme.people[k];
        context.lineWidth = (this.pictures ? 1.8 : 1.4) * thin;
        if (options.isAlarm(moment.frame, k)) this.drawAlarm(centre, v[k], l[k], theme, thin);
        else if (half < SMALL * thin) this.drawRect(centre - half, v[k] - l[k] / 2, 2 * half, l[k], theme.dark);
        else this.drawRound(centre - half, v[k] - l[k] / 2, 2 * half, l[k], theme.dark);
      }
    }

    /** A box that shows nobody: crossed out. */
    drawAlarm(u, v, l, theme, thin) {
      const { context } = this, half = 0.5 * ASPECT * l;
      if (this.pictures) this.drawHalo(u - half, v - l / 2, 2 * half, l, theme.dark);
      context.strokeStyle = theme.warn;
      context.setLineDash([5 * thin, 3 * thin]);
      context.strokeRect(u - half, v - l / 2, 2 * half, l);
      context.setLineDash([]);
      context.beginPath();
      context.moveTo(u - half, v - l / 2); context.lineTo(u + half, v + l / 2);
      context.moveTo(u + half, v - l / 2); context.lineTo(u - half, v + l / 2);
      context.globalAlpha = 0.5;
      context.stroke();
      context.globalAlpha = 1;
    }

    /** Where the boxes of people without one would be: dotted, and dark and light on a picture. */
    drawUnboxed({ u, v, l, N }, theme, scale) {
      const { context, canvas, clip } = this, thin = canvas.ratio / scale, { round, width } = clip.picture;
      context.beginPath();
      for (let n = 0; n < N; n++) {
        if (l[n] !== l[n]) continue;
        const half = 0.5 * ASPECT * l[n];
        context.rect(u[n] - half, v[n] - l[n] / 2, 2 * half, l[n]);
        if (round && (u[n] < half || u[n] > width - half)) {
          context.rect(u[n] + (u[n] < half ? 1 : -1) * width - half, v[n] - l[n] / 2, 2 * half, l[n]);
        }
      }
      context.lineWidth = 1.2 * thin;
      if (this.pictures) {
        context.strokeStyle = "#fff";
        context.stroke();
      }
      context.strokeStyle = this.pictures ? "#000" : theme.faint;
      context.setLineDash([2.5 * thin, 2.5 * thin]);
      context.stroke();
      context.setLineDash([]);
    }

    /** Far people, of whom there are many: corners are too small to be round, and a plain box is quickly drawn. */
    drawRect(left, top, width, height, dark) {
      const { context } = this;
      if (this.pictures) this.drawHalo(left, top, width, height, dark);
      context.globalAlpha = this.pictures ? FILL_ON_PICTURE : FILL;
      context.fillRect(left, top, width, height);
      context.globalAlpha = 1;
      context.strokeRect(left, top, width, height);
    }

    /** A line of the paper's shade under a box, so that its colour shows on any picture. */
    drawHalo(left, top, width, height, dark) {
      const { context } = this, { lineWidth, strokeStyle } = context;
      context.beginPath();
      context.roundRect(left, top, width, height, 0.25 * width);
      context.lineWidth = 2.2 * lineWidth;
      context.strokeStyle = dark ? "rgb(0 0 0 / 60%)" : "rgb(255 255 255 / 75%)";
      context.stroke();
      Object.assign(context, { lineWidth, strokeStyle });
    }

    drawRound(left, top, width, height, dark) {
      const { context } = this;
      if (this.pictures) this.drawHalo(left, top, width, height, dark);
      context.beginPath();
      context.roundRect(left, top, width, height, 0.25 * width);
      context.globalAlpha = this.pictures ? FILL_ON_PICTURE : FILL;
      context.fill();
      context.globalAlpha = 1;
      context.stroke();
    }

    drawCompass(theme) {
      const { context, canvas, shown, scale } = this, size = (11 * canvas.ratio) / scale;
      context.font = `${size}px ${parts.FONT}`;
      context.textBaseline = "top";
      for (const [name, share] of MARKS) {
        const x = share * shown.width;
        context.textAlign = share === 0 ? "left" : share === 1 ? "right" : "center";
        parts.label(context, name, x + (share === 0 ? 0.5 : share === 1 ? -0.5 : 0) * size, shown.top + 0.5 * size,
          this.pictures ? theme.ink : theme.faint, theme.paper);
        context.fillStyle = theme.faint;
        context.fillRect(x - 0.05 * size, shown.top, 0.1 * size, 0.4 * size);
      }
    }

    /** Ids over the nearest boxes, as far as they do not cover one another. */
    drawIds(moment, theme) {
      const { context, canvas, scale, order, clip } = this, size = (10 * canvas.ratio) / scale;
      context.font = `${size}px ${parts.FONT}`;
      context.textAlign = "center";
      context.textBaseline = "bottom";
      const taken = (this.taken = this.taken || new Float64Array(64));
      let count = 0;
      for (let i = order.length - 1; i >= 0 && count < 48; i--) {
        const k = order[i], { u, v, l } = moment.boxes;
        if (l[k] !== l[k]) continue;
        let free = true;
        for (let n = 0; n < count; n++) free = free && Math.abs(taken[n] - u[k]) > 2.4 * size;
        if (!free) continue;
        taken[count++] = u[k];
        const y = Math.max(v[k] - l[k] / 2 - 0.2 * size, this.shown.top + 3 * size);
        parts.label(context, clip.tracks[k], u[k], y, theme.ink, theme.paper);
      }
    }

    drawSelected(moment, theme, { selected }) {
      const without = moment.others && (selected >= this.clip.K || moment.others.reason(selected));
      const { u, v, l } = without ? moment.others : moment.boxes;
      if (!(l[selected] === l[selected])) return;
      const { context, canvas, scale, clip, shown } = this, half = 0.5 * ASPECT * l[selected] + 3 / scale;
      const size = (12 * canvas.ratio) / scale;
      context.lineWidth = (2.5 * canvas.ratio) / scale;
      context.strokeStyle = theme.accent;
      context.strokeRect(u[selected] - half, v[selected] - l[selected] / 2, 2 * half, l[selected]);
      context.font = `600 ${size}px ${parts.FONT}`;
      context.textAlign = "center";
      context.textBaseline = "bottom";
      const y = Math.max(v[selected] - l[selected] / 2 - 0.2 * size, shown.top + 2.6 * size);
      parts.label(context, selected < clip.K ? `person ${clip.tracks[selected]}` : "no box", Math.min(Math.max(u[selected], 3 * size),
        shown.width - 3 * size), y, theme.ink, theme.paper);
    }

    /** The nearest person whose box lies under a point of the view (CSS px), or -1. */
    pick(moment, x, y) {
      const rate = this.shown.width / this.canvas.clientWidth, column = x * rate, row = y * rate + this.shown.top;
      for (let i = this.order.length - 1; i >= 0; i--) {
        const k = this.order[i], { u, v, l } = moment.boxes;
        const across = Math.abs(u[k] - column), slack = 3 * rate;
        if (across < 0.5 * ASPECT * l[k] + slack && Math.abs(v[k] - row) < l[k] / 2 + slack) return k;
      }
      const { others } = moment;
      for (let n = 0; others && n < others.N; n++) {
        const { u, v, l } = others;
        if (Math.abs(u[n] - column) < 0.5 * ASPECT * l[n] && Math.abs(v[n] - row) < l[n] / 2) return n;
      }
      return -1;
    }
  }

  Object.assign(parts, { EgoView, Pictures });
})(vbbench.player.parts);
