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
