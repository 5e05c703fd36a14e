// SPDX-License-Identifier: LGPL-2.1-or-later
// The points over the picture: shapes and colours as csdtrack's overlay has them (docs/elements.md). csd-report's page has it, and that of
// pipelines/stream --web.
"use strict";

const csdMarkers = (() => {
  const REACH = 18; // px of the screen from a click to a point
  const HALO = "rgba(0, 0, 0, 0.8)";
  const styles = getComputedStyle(document.documentElement);
  const colours = Object.fromEntries(
    ["learning", "tracked", "occluded", "lost", "out", "ended"].map((state) => [state, styles.getPropertyValue(`--${state}`).trim()]));
  // As over the video: what claims nothing shall not distract.
  const drawn = { ...colours, lost: "rgba(200, 200, 200, 0.65)", out: "rgba(200, 200, 200, 0.65)" };

  /** The outline of a state's shape around 0,0 with this radius, and whether it has a dot. */
  function outline(state, r) {
    const path = new Path2D();
    const small = 0.6 * r;
    const polygon = (...points) => {
      points.forEach(([x, y], i) => (i ? path.lineTo(x, y) : path.moveTo(x, y)));
      path.closePath();
    };
    if (state === "learning") polygon([-1.2 * r, 0], [0, -1.2 * r], [1.2 * r, 0], [0, 1.2 * r]);
    else if (state === "tracked") path.arc(0, 0, r, 0, 2 * Math.PI);
    else if (state === "occluded") polygon([-0.9 * r, -0.9 * r], [0.9 * r, -0.9 * r], [0.9 * r, 0.9 * r], [-0.9 * r, 0.9 * r]);
    else if (state === "lost") {
      path.moveTo(-small, -small), path.lineTo(small, small);
      path.moveTo(-small, small), path.lineTo(small, -small);
    } else if (state === "out") polygon([0, -small], [small, small], [-small, small]);
    return path;
  }

  /** From pixels of the tracks to the picture as it is shown, 0…1 each. Pixel centres are at integers. */
  function place(about, x, y) {
    let [u, v, w, h] = [x + 0.5, y + 0.5, about.width, about.height];
    if (about.mirrored) u = w - u;
    if (about.turn === 90) [u, v] = [h - v, u];
    else if (about.turn === 180) [u, v] = [w - u, h - v];
    else if (about.turn === 270) [u, v] = [v, w - u];
    return [u / about.shown[0], v / about.shown[1]];
  }

  class Overlay {
    constructor(canvas, about) {
      Object.assign(this, { canvas, about, context: canvas.getContext("2d"), ids: true, features: [] });
    }

    /** Of the screen's pixels, where a point lies on the canvas. */
    at(x, y) {
      const [u, v] = place(this.about, x, y);
      return [u * this.canvas.clientWidth, v * this.canvas.clientHeight];
    }

    /** features: [{id, x, y, state}], pixels of the tracks; selected: an id or null; trail: where that was before, [x, y] each, null where it
     *  wasn't seen. */
    draw(features, selected = null, trail = []) {
      const { canvas, context } = this;
      const ratio = window.devicePixelRatio || 1;
      const width = Math.round(canvas.clientWidth * ratio), height = Math.round(canvas.clientHeight * ratio);
      if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
      context.setTransform(ratio, 0, 0, ratio, 0, 0);
      context.clearRect(0, 0, canvas.clientWidth, canvas.clientHeight);
      this.features = features.filter((f) => f.state !== "ended");
      const lines = canvas.clientHeight;
      const r = Math.max(4, lines / 80), stroke = Math.max(1.5, lines / 400), text = Math.max(9, lines / 46);
      context.lineJoin = context.lineCap = "round";
      context.font = `${text}px ${getComputedStyle(document.body).fontFamily}`;
      context.textBaseline = "bottom";
      this.trail(trail, stroke);
      // What claims nothing first, the chosen one last: it is not to be covered.
      const order = { out: 0, lost: 1, occluded: 2, learning: 3, tracked: 4 };
      const sorted = [...this.features].sort((a, b) => (a.id === selected) - (b.id === selected) || order[a.state] - order[b.state]);
      for (const { id, x, y, state } of sorted) {
        const [px, py] = this.at(x, y);
        const chosen = id === selected;
        context.save();
        context.translate(px, py);
        if (chosen) {
          context.beginPath();
          context.arc(0, 0, 2.2 * r, 0, 2 * Math.PI);
          context.lineWidth = stroke * 1.6;
          context.strokeStyle = "#fff";
          context.stroke();
        }
        const shape = outline(state, r);
        for (const [colour, extra] of [[HALO, 2], [drawn[state], 0]]) {
          context.strokeStyle = context.fillStyle = colour;
          context.lineWidth = stroke + extra;
          context.stroke(shape);
          if (state === "tracked") {
            context.beginPath();
            context.arc(0, 0, stroke * 0.75 + extra / 2, 0, 2 * Math.PI);
            context.fill();
          }
        }
        if (this.ids || chosen) {
          const away = chosen ? 2.4 * r : 1.3 * r;
          context.lineWidth = 3;
          context.strokeStyle = HALO;
          context.fillStyle = chosen ? "#fff" : drawn[state];
          context.strokeText(id, away, -0.5 * r);
          context.fillText(id, away, -0.5 * r);
        }
        context.restore();
      }
    }

    trail(places, stroke) {
      const { context } = this;
      context.beginPath();
      let joined = false;
      for (const place of places) {
        if (place && joined) context.lineTo(...this.at(...place));
        else if (place) context.moveTo(...this.at(...place));
        joined = Boolean(place);
      }
      context.lineWidth = stroke;
      context.strokeStyle = "rgba(255, 255, 255, 0.85)";
      context.stroke();
    }

    /** The id of the point nearest to a place on the canvas, null if none is near. */
    nearest(x, y) {
      let best = null, least = Math.max(REACH, this.canvas.clientHeight / 30);
      for (const feature of this.features) {
        const [px, py] = this.at(feature.x, feature.y);
        const distance = Math.hypot(px - x, py - y);
        if (distance < least) [best, least] = [feature.id, distance];
      }
      return best;
    }
  }

  /** A state's marker for the list. */
  function icon(state) {
    const shapes = {
      learning: '<path d="M1 7 7 1l6 6-6 6z"/>',
      tracked: '<circle cx="7" cy="7" r="5.2"/><circle cx="7" cy="7" r="1" fill="currentColor"/>',
      occluded: '<path d="M2.5 2.5h9v9h-9z"/>',
      lost: '<path d="m3.5 3.5 7 7m0-7-7 7"/>',
      out: '<path d="m7 3 4 8H3z"/>',
      ended: "",
    };
    const colour = state === "lost" || state === "out" ? "#b5b5b5" : colours[state];
    return `<svg viewBox="0 0 14 14" fill="none" stroke="currentColor" stroke-width="1.8" color="${colour}" aria-hidden="true">${shapes[state]}</svg>`;
  }

  /** The states with their markers, for people. */
  const legend = () => Object.keys(colours).slice(0, 5).map((state) => `<span class="state">${icon(state)}${state}</span>`).join("");

  /** Calls show() with the time of each frame that is presented. Without the browser's callback for that, with the clock's time, less
   *  `early` (s). */
  function watch(video, show, early) {
    if (video.requestVideoFrameCallback) {
      const presented = (_now, { mediaTime }) => {
        show(mediaTime);
        video.requestVideoFrameCallback(presented);
      };
      video.requestVideoFrameCallback(presented);
      return;
    }
    let last = -1;
    const tick = () => {
      const time = Math.max(0, video.currentTime + 1e-3 - early);
      if (Math.abs(time - last) > 1e-4) show((last = time));
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  /** Gives the stage the picture's shape, as large as there is room. */
  function fit(room, stage, aspect) {
    const width = Math.floor(Math.min(room.clientWidth, room.clientHeight * aspect));
    stage.style.width = `${width}px`;
    stage.style.height = `${Math.round(width / aspect)}px`;
  }

  return { Overlay, colours, fit, icon, legend, place, watch };
})();
