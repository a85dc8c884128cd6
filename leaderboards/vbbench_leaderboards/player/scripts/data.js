/* The player's data: the decoding of what player/coding.py and player/clip.py wrote. */
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
