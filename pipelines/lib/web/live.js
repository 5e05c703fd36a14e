// SPDX-License-Identifier: LGPL-2.1-or-later
// The live page: records of /live (../web.py), the video by Media Source Extensions, the tracks of the frame that is shown over it.
"use strict";

const csdLive = (() => {
  const $ = (id) => document.getElementById(id);
  const video = $("video");
  const HEAD = 13; // bytes before a record's content
  const KEPT = 500; // frames whose tracks are kept
  const BACK = 3; // s of video that are kept at least, twice that at most
  const LATE = 1; // s behind the newest frame, from which it is jumped to
  const BEHIND = 0.5; // s, from which the video plays faster
  const MOST = 64 << 20; // bytes that wait for the decoder

  const about = { width: 0, height: 0, turn: 0, shown: [1, 1] }; // of the tracks
  const overlay = new csdMarkers.Overlay($("overlay"), about);
  let frames = new Map(); // time (µs), ascending: the frame's line, null while it isn't there
  let shown = null; // what the picture shows: {time, line}
  let connection = 0; // counted
  let told = null; // the newest answer to a click

  const trouble = (text) => (($("trouble").textContent = text), ($("trouble").hidden = !text));

  // ---- the video ---------------------------------------------------------------------------------------------------

  /** Takes what a connection brings: heads and frames. */
  class Player {
    async open() {
      this.media = new MediaSource();
      this.waiting = [];
      const opened = new Promise((done) => this.media.addEventListener("sourceopen", done, { once: true }));
      video.src = URL.createObjectURL(this.media);
      await opened;
      URL.revokeObjectURL(video.src);
    }

    /** type: of what follows, a string; or bytes. */
    add(what) {
      this.waiting.push(what);
      if (this.waiting.reduce((sum, one) => sum + one.length, 0) > MOST) throw new Error("the browser is too slow for this stream");
      this.go();
    }

    go() {
      if (this.media.readyState !== "open" || this.buffer?.updating) return;
      if (this.buffer && this.follow()) return;
      const type = typeof this.waiting[0] === "string" ? this.waiting.shift() : null;
      if (type && this.buffer) this.buffer.changeType(type);
      else if (type) {
        this.buffer = this.media.addSourceBuffer(type);
        this.buffer.onupdateend = () => this.go();
      }
      const until = this.waiting.findIndex((one) => typeof one === "string");
      const bytes = this.waiting.splice(0, until < 0 ? this.waiting.length : until);
      if (bytes.length) this.buffer.appendBuffer(joined(bytes));
    }

    /** Keeps the picture close to the newest frame. Whether old ones are being removed. */
    follow() {
      const there = this.buffer.buffered;
      if (!there.length) return false;
      const begin = there.start(there.length - 1), end = there.end(there.length - 1);
      const behind = end - video.currentTime;
      // Also over a gap, where a frame was left out for a slow connection.
      if (video.currentTime < begin || behind > LATE) video.currentTime = Math.max(begin, end - 0.1);
      video.playbackRate = behind > BEHIND ? 1.1 : 1;
      if (video.paused) video.play().catch(() => {});
      if (there.start(0) > end - 2 * BACK) return false;
      this.buffer.remove(0, end - BACK);
      return true;
    }
  }

  function joined(parts) {
    const all = new Uint8Array(parts.reduce((sum, part) => sum + part.length, 0));
    parts.reduce((at, part) => (all.set(part, at), at + part.length), 0);
    return all;
  }

  // ---- the connection ----------------------------------------------------------------------------------------------

  /** Until it ends. */
  async function receive() {
    const response = await fetch("live");
    if (!response.ok) throw new Error(await response.text());
    ++connection;
    frames = new Map(); // the times may begin anew
    const player = new Player();
    await player.open();
    const reader = response.body.getReader();
    try {
      for (let rest = new Uint8Array(); ; ) {
        const { done, value } = await reader.read();
        if (done) return;
        rest = joined([rest, value]);
        for (let size; rest.length >= HEAD && rest.length >= (size = HEAD + new DataView(rest.buffer, rest.byteOffset).getUint32(1)); rest = rest.slice(size)) {
          take(player, String.fromCharCode(rest[0]), Number(new DataView(rest.buffer, rest.byteOffset).getBigUint64(5)), rest.slice(HEAD, size));
          if (video.error) throw new Error(`the browser can't play it: ${video.error.message}`);
        }
      }
    } finally {
      reader.cancel().catch(() => {});
    }
  }

  function take(player, kind, time, content) {
    const text = () => new TextDecoder().decode(content);
    if (kind === "H") {
      const { type } = JSON.parse(text());
      if (!MediaSource.isTypeSupported(type)) throw new Error(`this browser can't play H.264 (${type})`);
      player.add(type);
    } else if (kind === "I") player.add(content);
    else if (kind === "V") {
      if (!frames.has(time)) frames.set(time, null);
      player.add(content);
      trouble("");
    } else if (kind === "T") frames.set(time, JSON.parse(text()));
    for (const old of frames.keys()) {
      if (frames.size <= KEPT) break;
      frames.delete(old);
    }
  }

  async function live() {
    for (;;) {
      const why = await receive().then(() => "the stream has ended", (error) => error.message);
      trouble(`${why}; trying again`);
      await new Promise((done) => setTimeout(done, 1000));
    }
  }

  // ---- the tracks --------------------------------------------------------------------------------------------------

  /** Draws the tracks of the frame that the picture shows at this time of the media (s): of the last one that has begun. */
  function show(seconds) {
    let time = null;
    for (const one of frames.keys()) if (one <= 1e6 * seconds + 500 && one > (time ?? -1)) time = one;
    const line = time === null ? null : frames.get(time);
    shown = { time, line };
    if (line) Object.assign(about, { width: line.width, height: line.height, shown: [line.width, line.height] });
    overlay.draw(line ? line.features : []);
    $("facts").textContent = line ? `${line.width}×${line.height} · ${line.algorithm} · frame ${line.frame}` : "";
  }

  function tell(answer) {
    told = answer;
    $("told").textContent = answer.error ?? (answer.added === undefined ? `Point ${answer.removed} is removed.` : `Point ${answer.added} is added.`);
  }

  async function wish(what) {
    try {
      const response = await fetch("points", { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(what) });
      tell(response.ok ? await response.json() : { error: await response.text() });
    } catch (error) {
      tell({ error: error.message });
    }
  }

  function fit() {
    csdMarkers.fit($("room"), $("stage"), video.videoWidth ? video.videoWidth / video.videoHeight : 4 / 3);
    overlay.draw(overlay.features);
  }

  $("overlay").onclick = ({ offsetX, offsetY }) => {
    if (!shown?.line) return tell({ error: "there are no tracks of this frame: click again" });
    const { clientWidth, clientHeight } = $("overlay");
    wish({ x: (offsetX / clientWidth) * about.width - 0.5, y: (offsetY / clientHeight) * about.height - 0.5, time: shown.time });
  };
  $("overlay").oncontextmenu = (event) => {
    event.preventDefault();
    const id = overlay.nearest(event.offsetX, event.offsetY);
    if (id === null) tell({ error: "no point is near" });
    else wish({ remove: id });
  };
  $("ids").onchange = () => ((overlay.ids = $("ids").checked), overlay.draw(overlay.features));
  document.onkeydown = (event) => event.key === "i" && !event.ctrlKey && !event.altKey && !event.metaKey && $("ids").click();
  $("legend").innerHTML = csdMarkers.legend();
  new ResizeObserver(fit).observe($("room"));
  video.onresize = fit;
  csdMarkers.watch(video, show, 0);
  if (window.MediaSource) live();
  else trouble("this browser has no Media Source Extensions, which the picture needs: use another");

  /** What the page shows, for scripts that drive it. */
  return {
    state: () => ({
      frame: shown?.line ? shown.line.frame : null,
      drawn: overlay.features,
      connection,
      told,
      behind: video.buffered.length ? video.buffered.end(video.buffered.length - 1) - video.currentTime : null,
      kept: video.buffered.length ? video.buffered.end(video.buffered.length - 1) - video.buffered.start(0) : 0,
    }),
  };
})();
