/* The player's data: the decoding of what site/clip.py wrote. */
"use strict";
vbbench.player = { parts: {} };

(function (parts) {
  /** The value of a data file, as a promise. */
  async function load(name) {
    const value = await vbbench.load(`player/${name}`);
    if (value === undefined) throw new Error(`The file data/player/${name}.js is not of this page.`);
    return value;
  }

  async function inflate(text) {
    if (typeof DecompressionStream === "undefined") {
      throw new Error("This browser cannot unpack the recordings; one of 2023 or later can.");
    }
    const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  }

  /** Numbers from bytes of seven bits, one after the other. */
  class Reader {
    constructor(bytes) {
      this.bytes = bytes;
      this.at = 0;
    }

    next() {
      let bits = 0, shift = 0, byte;
      do {
        byte = this.bytes[this.at++];
        bits |= (byte & 127) << shift;
        shift += 7;
      } while (byte > 127);
      return (bits >>> 1) ^ -(bits & 1);
    }

    /** Flags [T, K], which lie a track after the other as lengths of runs. */
    flags(T, K) {
      const mask = new Uint8Array(T * K);
      let place = 0;
      for (let run = 0, runs = this.next(); run < runs; run++) {
        const stop = place + this.next();
        for (; place < stop; place++) if (run % 2) mask[(place % T) * K + Math.floor(place / T)] = 1;
      }
      return mask;
    }

    /** Values [T, K] where `present`, NaN elsewhere, from their differences in time. */
    column(present, T, K, order, quantum) {
      const out = new Float64Array(T * K).fill(NaN);
      let first = 0;
      for (let k = 0; k < K; k++) {
        let rank = 0, value = 0, step = 0;
        for (let i = k; i < T * K; i += K) {
          if (!present[i]) continue;
          const read = this.next();
          if (order === 0) value = read;
          else if (rank === 0) value = first += read;
          else value += step = order === 2 && rank > 1 ? step + read : read;
          rank++;
          out[i] = value * quantum;
        }
      }
      return out;
    }
  }

  const METRE = 1e-3, PIXEL = 0.1, RADIAN = 1e-4, SMOOTH = 2;

  /** A sequence: what is published of it, and its truth; [T] of the observer, [T, K] of the people. */
  async function decodeClip(value) {
    const reader = new Reader(await inflate(value.data));
    const T = value.frames, K = value.tracks.length, always = new Uint8Array(T).fill(1);
    const clip = { ...value, T, K, known: reader.flags(T, K), observed: reader.flags(T, K), given: reader.flags(T, K) };
    const column = (mask, width, quantum) => reader.column(mask, T, width, SMOOTH, quantum * value.coarse);
    const own = (quantum) => column(always, 1, quantum);
    [clip.x, clip.y, clip.yaw] = [own(METRE), own(METRE), own(RADIAN)];
    [clip.px, clip.py] = [0, 1].map(() => column(clip.known, K, METRE));
    [clip.u, clip.v, clip.l] = [0, 1, 2].map(() => column(clip.observed, K, PIXEL));
    delete clip.data;
    return clip;
  }

  /** What a solver says of a clip, in the clip's own coordinates. */
  async function decodeEstimate(value, clip) {
    const reader = new Reader(await inflate(value.data));
    const { T, K } = clip, posed = reader.flags(T, 1), placed = reader.flags(T, K);
    for (let i = 0; i < placed.length; i++) placed[i] ^= clip.observed[i];
    const read = (mask, width, quantum, truth) => {
      const out = reader.column(mask, T, width, value.order, quantum * value.coarse);
      for (let i = 0; i < out.length; i++) if (!Number.isNaN(truth[i])) out[i] += truth[i];
      return out;
    };
    const estimate = {};
    for (const [name, quantum] of [["x", METRE], ["y", METRE], ["yaw", RADIAN]]) {
      estimate[name] = read(posed, 1, quantum, clip[name]);
    }
    for (const name of ["px", "py"]) estimate[name] = read(placed, K, METRE, clip[name]);
    return estimate;
  }

  const QUANTA = { METRE, PIXEL };

  Object.assign(parts, { load, inflate, Reader, QUANTA, decodeClip, decodeEstimate });
})(vbbench.player.parts);
/* What is so at a moment, between two frames if need be, and the errors of every frame. */
"use strict";
(function (parts) {
  const START = 2; // frames 0 and 1 are given under every protocol

  const wrap = (angle) => angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI));

  /** [T, K] whether a position is scored under the board's protocol: observed, from the third frame on, not given. */
  function scoredPositions(clip, given) {
    const scored = new Uint8Array(clip.T * clip.K);
    for (let i = START * clip.K; i < scored.length; i++) {
      scored[i] = clip.observed[i] && clip.known[i] && !(given === "arrivals" && clip.given[i]) ? 1 : 0;
    }
    return scored;
  }

  /** Add to an estimate its errors in m: `dx` [T] mean over people, `dt` [T] of the observer, `dr` [T] in rad. */
  function addErrors(estimate, clip, scored) {
    const { T, K } = clip;
    for (const name of ["dx", "dt", "dr"]) estimate[name] = new Float64Array(T).fill(NaN);
    for (let t = START; t < T; t++) {
      let sum = 0, count = 0;
      for (let i = t * K; i < (t + 1) * K; i++) {
        const error = Math.hypot(estimate.px[i] - clip.px[i], estimate.py[i] - clip.py[i]);
        if (scored[i] && !Number.isNaN(error)) { sum += error; count++; }
      }
      if (count) estimate.dx[t] = sum / count;
      estimate.dt[t] = Math.hypot(estimate.x[t] - clip.x[t], estimate.y[t] - clip.y[t]);
      estimate.dr[t] = Math.abs(wrap(estimate.yaw[t] - clip.yaw[t]));
    }
    return estimate;
  }

  function blend(from, out, row, width, share, turn) {
    const last = row + width < from.length && share > 0;
    for (let k = 0; k < width; k++) {
      const a = from[row + k], b = last ? from[row + width + k] : a;
      if (share === 0 || a !== a || b !== b) out[k] = share < 0.5 ? a : b;
      else {
        let step = b - a;
        if (turn) step -= turn * Math.round(step / turn);
        out[k] = a + share * step;
      }
    }
  }

  /** One moment of a clip and its estimates, in arrays that are made once. */
  class Moment {
    constructor(clip, estimates) {
      this.clip = clip;
      this.truth = this.room(clip);
      this.boxes = { u: new Float64Array(clip.K), v: new Float64Array(clip.K), l: new Float64Array(clip.K) };
      this.estimates = estimates.map((estimate) => this.room(estimate));
      this.others = null; // until they are loaded
      this.frame = 0;
      this.at = 0;
    }

    room(source) {
      const { K } = this.clip;
      return {
        source, pose: { x: new Float64Array(1), y: new Float64Array(1), yaw: new Float64Array(1) },
        px: new Float64Array(K), py: new Float64Array(K), x: 0, y: 0, yaw: 0,
      };
    }

    /** Go to frame `at`, between two if `smooth`, otherwise to the earlier; boxes stay with a picture of it if `pictured`. */
    go(at, smooth, pictured) {
      const { clip } = this, whole = Math.floor(at), share = smooth ? at - whole : 0;
      this.at = at;
      this.frame = whole;
      this.share = share;
      this.fill(this.truth, whole, share);
      for (const room of this.estimates) this.fill(room, whole, share);
      const boxShare = pictured ? 0 : share;
      const turn = clip.picture.round ? clip.picture.width : 0;
      blend(clip.u, this.boxes.u, whole * clip.K, clip.K, boxShare, turn);
      blend(clip.v, this.boxes.v, whole * clip.K, clip.K, boxShare, 0);
      blend(clip.l, this.boxes.l, whole * clip.K, clip.K, boxShare, 0);
      if (this.others) this.others.go(whole, share, boxShare);
    }

    /** Place of a person, [x, y] in m, with a box or without; NaN of nobody. */
    placeOf(n) {
      const { others, truth, clip } = this;
      if (others && (n >= clip.K || others.reason(n))) return [others.px[n], others.py[n]];
      return n < clip.K ? [truth.px[n], truth.py[n]] : [NaN, NaN];
    }

    /** Whether a disc is drawn of a track's person: it has a box, or there is no telling yet who has none. */
    isShown(n) { return !this.others || this.clip.observed[this.frame * this.clip.K + n] === 1; }

    fill(room, frame, share) {
      const { source, pose } = room, { K } = this.clip;
      blend(source.px, room.px, frame * K, K, share, 0);
      blend(source.py, room.py, frame * K, K, share, 0);
      blend(source.x, pose.x, frame, 1, share, 0);
      blend(source.y, pose.y, frame, 1, share, 0);
      blend(source.yaw, pose.yaw, frame, 1, share, 2 * Math.PI);
      [room.x, room.y, room.yaw] = [pose.x[0], pose.y[0], pose.yaw[0]];
    }
  }

  Object.assign(parts, { Moment, scoredPositions, addErrors, blend, wrap, START });
})(vbbench.player.parts);
/* People without a box, and why they have none: columns are the clip's tracks, then people who are in none of them. */
"use strict";
(function (parts) {
  /** By the number that player/unboxed.py gives a reason: in few words, and about one person. */
  const REASONS = [
    ["", ""],
    ["outside the picture", "no box: outside the picture"],
    ["cut off by its border", "no box: mostly beyond the picture's border"],
    ["hidden", "no box: hidden by people in front"],
    ["too small", "no box: smaller in the picture than any box of this sequence"],
    ["missed", "no box: missed by detector or tracker"],
    ["left out", "no box: not among the people of this dataset"],
  ];

  /** What a file of people without boxes holds, in the clip's own coordinates. */
  async function decodeOthers(value, clip) {
    const reader = new parts.Reader(await parts.inflate(value.data)), { METRE, PIXEL } = parts.QUANTA;
    const { T, K } = clip, M = value.people, N = K + M, told = reader.flags(T, N), boxed = reader.flags(T, N);
    const reasons = Uint8Array.from(reader.column(told, T, N, 1, 1), (code) => code || 0);
    const [u, v, l] = [0, 1, 2].map(() => reader.column(boxed, T, N, 2, PIXEL * value.coarse));
    const mine = new Uint8Array(T * M);
    for (let i = 0; i < mine.length; i++) mine[i] = told[Math.floor(i / M) * N + K + (i % M)];
    const [x, y] = [0, 1].map(() => reader.column(mine, T, M, 2, METRE * value.coarse));
    const px = new Float64Array(T * N).fill(NaN), py = px.slice();
    for (let i = 0; i < px.length; i++) {
      const t = Math.floor(i / N), n = i % N;
      if (!told[i]) continue;
      px[i] = n < K ? clip.px[t * K + n] : x[t * M + n - K];
      py[i] = n < K ? clip.py[t * K + n] : y[t * M + n - K];
    }
    return { N, reasons, boxes: { u, v, l }, px, py };
  }

  /** Them at one moment, in arrays that are made once. */
  class Others {
    constructor(clip, source) {
      const room = () => new Float64Array(source.N).fill(NaN);
      Object.assign(this, { clip, source, N: source.N, px: room(), py: room(), u: room(), v: room(), l: room(), row: 0 });
    }

    go(frame, share, boxShare) {
      const { source, N, clip } = this, turn = clip.picture.round ? clip.picture.width : 0;
      this.row = frame * N;
      parts.blend(source.px, this.px, this.row, N, share, 0);
      parts.blend(source.py, this.py, this.row, N, share, 0);
      parts.blend(source.boxes.u, this.u, this.row, N, boxShare, turn);
      parts.blend(source.boxes.v, this.v, this.row, N, boxShare, 0);
      parts.blend(source.boxes.l, this.l, this.row, N, boxShare, 0);
    }

    /** Why somebody has no box now; 0 if there is one, or nobody. */
    reason(n) { return this.source.reasons[this.row + n]; }

    /** How many have no box now, by reason. */
    count() {
      const counts = REASONS.map(() => 0);
      for (let n = 0; n < this.N; n++) counts[this.reason(n)] += 1;
      return counts;
    }
  }

  /** Boxes of a moment that are known to show nobody: the truth has no place for them. */
  function isFalseAlarm(s, i) { return s.index.truth !== "poses" && s.clip.observed[i] === 1 && !s.clip.known[i]; }

  /** The sentence under the camera's view: how many boxes, and why some people have none. */
  function tellBoxes(s) {
    const { clip, moment } = s, base = moment.frame * clip.K;
    let boxes = 0, alarms = 0;
    for (let i = base; i < base + clip.K; i++) {
      boxes += clip.observed[i];
      alarms += isFalseAlarm(s, i) ? 1 : 0;
    }
    const nobody = s.board.tier === "footage" || s.index.truth === "relative" ? "nobody whose place is known" : "nobody";
    const counts = moment.others ? moment.others.count() : [], all = counts.slice(1).reduce((sum, n) => sum + n, 0);
    const why = REASONS.map(([word], n) => (n && counts[n] ? `${counts[n]} ${word}` : "")).filter(Boolean).join(", ");
    return { boxes: `${boxes} ${boxes === 1 ? "box" : "boxes"}`, alarms: alarms ? `${alarms} of them ${alarms === 1 ? "shows" : "show"} ${nobody}` : "",
      without: all ? `${all} ${all === 1 ? "person" : "people"} without: ${why}` : "" };
  }

  Object.assign(parts, { decodeOthers, Others, isFalseAlarm, tellBoxes, REASONS });
})(vbbench.player.parts);
/* The moments that tell most: where a solver is lost, or where two solvers differ most. */
"use strict";
(function (parts) {
  const MOST = 5, APART = 1.5; // so many moments, seconds apart
  const LEVELS = 20, FEW = 2; // of what is told: within one, the first counts; the lowest tell nothing

  /** [T] how much a frame tells: the error, its mean over solvers, or of two the difference; beyond the cap it counts less and less. */
  function signal(curves, cap) {
    const tame = (value) => value / (1 + value / cap), T = curves.length ? curves[0].length : 0, out = new Float64Array(T);
    for (let t = 0; t < T; t++) {
      const values = curves.map((curve) => tame(curve[t])).filter((value) => value === value);
      if (curves.length === 2) out[t] = values.length === 2 ? Math.abs(values[0] - values[1]) : 0;
      else for (const value of values) out[t] += value / curves.length;
    }
    return out;
  }

  /** Frames that tell most, of nearly equal ones the first, none close to another that tells more. */
  function moments(curves, cap, dt) {
    const told = signal(curves, cap), most = told.reduce((one, other) => Math.max(one, other), 0), found = [];
    const level = (t) => Math.round((LEVELS * told[t]) / most);
    for (const t of most > 0 ? Array.from(told.keys()).sort((a, b) => level(b) - level(a) || a - b) : []) {
      if (found.length === MOST || level(t) <= FEW) break;
      if (found.every((other) => Math.abs(other - t) * dt >= APART)) found.push(t);
    }
    return found;
  }

  /** Which of two solvers is nearer the truth, in words. */
  function tellPair(drawn, curves) {
    if (curves.length !== 2) return "";
    const apart = curves[0].map((first, t) => curves[1][t] - first).filter((one) => one === one);
    const first = apart.filter((one) => one > 0).length, second = apart.filter((one) => one < 0).length, ahead = first >= second ? 0 : 1;
    return apart.length ? `${drawn[ahead].name} is nearer the truth in ${Math.max(first, second)} of ${apart.length} frames` : "";
  }

  Object.assign(parts, { moments, tellPair });
})(vbbench.player.parts);
