// SPDX-License-Identifier: LGPL-2.1-or-later
// The data: scripts that hand themselves over, loaded by time and forgotten again. A page opened from disk can't fetch.
"use strict";

const csdReport = (() => {
  const TRACKS_KEPT = 6; // chunks of 250 frames
  const MOTION_KEPT = 3; // chunks of some hundred kilobytes

  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer; // little-endian, as all that browsers run on

  /** Chunks of a kind: the ones used last, decoded. A chunk that is on its way is a promise. */
  class Chunks {
    constructor(name, kept, decode) {
      Object.assign(this, { name, kept, decode, there: new Map(), coming: new Map() });
    }

    /** The chunk, or null if it isn't there; it is used. */
    get(number) {
      const chunk = this.there.get(number);
      if (!chunk) return null;
      this.there.delete(number);
      this.there.set(number, chunk);
      return chunk;
    }

    load(number) {
      if (this.there.has(number)) return Promise.resolve(this.get(number));
      if (this.coming.has(number)) return this.coming.get(number);
      const promise = new Promise((done, fail) => {
        const script = document.createElement("script");
        script.src = `data/${this.name}-${String(number).padStart(5, "0")}.js`;
        script.onload = () => (script.remove(), this.coming.delete(number), done(this.get(number)));
        script.onerror = () => (script.remove(), this.coming.delete(number), fail(new Error(`${script.src} is missing`)));
        document.head.append(script);
      });
      this.coming.set(number, promise);
      return promise;
    }

    /** Called by the chunk's script. */
    take(number, told) {
      this.there.set(number, this.decode(told));
      for (const old of this.there.keys()) {
        if (this.there.size <= this.kept) break;
        this.there.delete(old);
      }
    }
  }

  const tracks = new Chunks("tracks", TRACKS_KEPT, (told) => ({
    ids: told.ids,
    frames: new Uint32Array(bytes(told.frames)),
    x: new Uint16Array(bytes(told.x)),
    y: new Uint16Array(bytes(told.y)),
    state: new Uint8Array(bytes(told.state)),
    confidence: new Uint8Array(bytes(told.confidence)),
  }));

  const UNKNOWN = -32768;
  const pixels = (text, step) => Float32Array.from(new Int16Array(bytes(text)), (v) => (v === UNKNOWN ? NaN : v * step));
  const displacement = (told) => ({ first: told.first, dx: pixels(told.dx, told.dx_step), dy: pixels(told.dy, told.dy_step) });

  const motion = new Chunks("motion", MOTION_KEPT, (told) => new Map(told.map((one) => [one.id, displacement(one)])));

  /** The last number of ascending `begins` that is at most `time`; −1 if none is. */
  function last(begins, time) {
    let low = 0, high = begins.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (begins[middle] <= time) low = middle + 1;
      else high = middle;
    }
    return low - 1;
  }

  const report = {
    tracksChunks: tracks,
    motionChunks: motion,
    last,

    // What the scripts call.
    index(told) {
      report.about = told;
      told.times = new Float64Array(bytes(told.times));
      told.byId = new Map(told.features.map((feature) => [feature.id, feature]));
      report.start();
    },
    tracks: (number, told) => tracks.take(number, told),
    motion: (number, told) => motion.take(number, told),
    scene(told) {
      report.times = new Float64Array(bytes(told.times));
      report.sceneMotion = displacement(told);
    },

    /** The frame that is shown at `time` (s): {number, time, chunk, row}; null if no line is of that frame; undefined if its chunk has to
     *  come first, `arrived` is called then. */
    frameAt(time, arrived) {
      const { chunks, interval, times } = report.about;
      const distance = (line) => Math.abs(times[line] - time);
      let line = Math.max(0, last(times, time + interval / 2));
      while (line > 0 && distance(line - 1) < distance(line)) --line;
      const number = last(chunks, line);
      const chunk = tracks.get(number);
      if (number + 1 < chunks.length && !tracks.there.has(number + 1)) tracks.load(number + 1).catch(report.trouble);
      if (!chunk) {
        tracks.load(number).then(arrived, report.trouble);
        return undefined;
      }
      if (distance(line) > 0.6 * interval) return null;
      const row = line - chunks[number];
      return { number: chunk.frames[row], time: times[line], chunk, row };
    },

    /** The features of a frame: [{id, x, y, state, confidence}], pixels of the tracks. */
    featuresOf({ chunk, row }) {
      const { left, top, step, states } = report.about;
      const found = [];
      for (let i = 0, cell = row * chunk.ids.length; i < chunk.ids.length; ++i, ++cell) {
        const state = states[chunk.state[cell]];
        if (!state) continue; // absent
        found.push({ id: chunk.ids[i], x: left + chunk.x[cell] * step, y: top + chunk.y[cell] * step, state,
          confidence: chunk.confidence[cell] / 255 });
      }
      return found;
    },

    /** Where a feature was seen in this frame and those before it, [x, y] each, null where it wasn't; as far as they are loaded. */
    trailOf({ chunk, row }, id, frames) {
      const { left, top, step } = report.about;
      const column = chunk.ids.indexOf(id), found = [];
      for (let i = Math.max(0, row - frames); column >= 0 && i <= row; ++i) {
        const cell = i * chunk.ids.length + column;
        found.push(chunk.state[cell] < 2 ? [left + chunk.x[cell] * step, top + chunk.y[cell] * step] : null);
      }
      return found;
    },

    trouble(error) {
      const place = document.getElementById("trouble");
      place.textContent = error.message;
      place.hidden = false;
    },
  };
  return report;
})();
