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
