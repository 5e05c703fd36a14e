// SPDX-License-Identifier: LGPL-2.1-or-later
// The page: which frame is shown, what is chosen, the list.
"use strict";

(() => {
  const $ = (id) => document.getElementById(id);
  const video = $("video");
  const ROW = 25; // px, a row of the list with its border
  const TRAIL = 25; // frames
  const dash = (value, digits) => (value === null || value === undefined ? "–" : value.toFixed(digits));
  let about, overlay, plot;
  let shown = { time: 0, frame: null }; // what the picture shows now
  let selected = null;
  let states = new Map(); // id: its state in this frame
  let order = { by: "id", down: true }; // start() turns it
  let listed = [];

  // ---- frames ------------------------------------------------------------------------------------------------------

  function draw() {
    const { frame } = shown;
    overlay.draw(frame ? csdReport.featuresOf(frame) : [], selected, frame && selected !== null ? csdReport.trailOf(frame, selected, TRAIL) : []);
  }

  /** Draws the tracks of the frame that the picture shows at this time of the media. */
  function show(time) {
    const frame = csdReport.frameAt(time, () => shown.time === time && show(time));
    shown = { time, frame: frame ?? null, pending: frame === undefined };
    draw();
    states = new Map(overlay.features.map((feature) => [feature.id, feature.state]));
    $("seek").value = time;
    $("clock").textContent = `${csdClock(time)} / ${csdClock(video.duration || about.end)}${frame ? ` · frame ${frame.number}` : ""}`;
    plot.move(time);
    loupe();
    list(order.by === "state" || $("here").checked);
  }

  /** Into the middle of the frame that is shown at this time, so that rounding leads to no other. */
  const seek = (time) => {
    video.currentTime = Math.min(Math.max(0, time + about.interval / 2), Math.max(0, (video.duration || about.end) - 1e-3));
  };
  const step = (frames) => {
    video.pause();
    seek(shown.time + frames * about.interval);
  };
  const toggle = () => (video.paused ? video.play().catch(csdReport.trouble) : video.pause());

  // ---- what is chosen ----------------------------------------------------------------------------------------------

  /** id: of a feature, or null for the scene. */
  function select(id) {
    selected = id;
    $("release").hidden = $("loupe").hidden = id === null;
    draw();
    loupe();
    tell();
    list(true);
    if (id === null) {
      plot.show(csdReport.sceneMotion, csdReport.times);
      return;
    }
    reveal(id);
    const feature = about.byId.get(id);
    if (feature.chunk === undefined) {
      plot.show({ first: 0, dx: [], dy: [] }, csdReport.times);
      return;
    }
    csdReport.motionChunks.load(feature.chunk).then((chunk) => selected === id && plot.show(chunk.get(id), csdReport.times), csdReport.trouble);
  }

  /** The panel of rhythms, and what the curve is called. */
  function tell() {
    const feature = selected === null ? null : about.byId.get(selected);
    $("what").textContent = feature ? `Feature ${selected}` : "Scene";
    $("what").title = feature ? "From where it was first seen" : "The sum of the features' median steps";
    const rhythms = feature ? feature.rhythms : about.scene;
    const rows = rhythms.map((r) => `<tr><td>${r.usual_name || "—"}</td><td class="number">${r.per_minute.toFixed(1)}</td>
      <td class="number">${r.period.toFixed(2)}</td><td class="number"><b>${r.amplitude.toFixed(2)}</b></td>
      <td class="number">${(100 * r.explained).toFixed(0)} %</td><td class="number">${r.false_alarm < 1e-4 ? "&lt; 10⁻⁴" : r.false_alarm.toFixed(4)}</td>
      ${feature ? "" : `<td class="number">${r.agreeing} of ${r.judged}</td>`}</tr>`);
    const life = feature
      ? `${csdClock(feature.from)} – ${csdClock(feature.to)}, seen for ${dash(feature.claimed, 1)} s; at most ${dash(feature.farthest, 1)} px from its start, ` +
        `usually ${dash(feature.speed, 1)} px/s`
      : "Of the whole scene. Click a point, on the picture or in the list, to follow it.";
    $("rhythms").innerHTML = (rows.length
      ? `<table><thead><tr><th></th><th class="number">/min</th><th class="number">period s</th>
        <th class="number" title="0 to peak">px</th><th class="number" title="Share of the motion that it makes up">share</th>
        <th class="number" title="Probability that noise alone shows it">noise</th>${feature ? "" : '<th class="number">features</th>'}</tr></thead>
        <tbody>${rows.join("")}</tbody></table>`
      : "<p>No rhythm stands out from noise.</p>") + `<p>${life}</p>`;
  }

  /** The picture around the chosen point. */
  function loupe() {
    const canvas = $("loupe");
    const feature = overlay.features.find(({ id }) => id === selected);
    if (canvas.hidden) return;
    const context = canvas.getContext("2d");
    context.clearRect(0, 0, canvas.width, canvas.height);
    if (!feature || !video.videoWidth) return;
    const [u, v] = csdMarkers.place(about, feature.x, feature.y);
    const size = canvas.width / 3;
    context.imageSmoothingEnabled = false;
    context.drawImage(video, u * video.videoWidth - size / 2, v * video.videoHeight - size / 2, size, size, 0, 0, canvas.width, canvas.height);
    context.strokeStyle = csdMarkers.colours[feature.state];
    context.lineWidth = 1.5;
    context.beginPath();
    const middle = canvas.width / 2;
    for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
      context.moveTo(middle + 6 * dx, middle + 6 * dy);
      context.lineTo(middle + 16 * dx, middle + 16 * dy);
    }
    context.stroke();
  }

  // ---- the list ----------------------------------------------------------------------------------------------------

  const amplitude = (feature, name) => feature.rhythms.find((r) => r.usual_name === name)?.amplitude ?? null;
  const lengths = (feature) => feature.counts.reduce((sum, n) => sum + n, 0);
  const columns = {
    state: (f) => (states.has(f.id) ? about.states.indexOf(states.get(f.id)) : 9),
    id: (f) => f.id,
    from: (f) => f.from,
    seen: (f) => (f.counts[0] + f.counts[1]) / lengths(f),
    farthest: (f) => f.farthest ?? null,
    speed: (f) => f.speed ?? null,
    heart: (f) => amplitude(f, "heart"),
    breath: (f) => amplitude(f, "breath"),
  };

  function sorted() {
    const value = columns[order.by];
    const of = new Map(about.features.map((f) => [f, value(f)]));
    const all = $("here").checked ? about.features.filter((f) => states.has(f.id)) : [...about.features];
    // What is unknown comes last, either way.
    return all.sort((a, b) => {
      const [p, q] = [of.get(a), of.get(b)];
      if (p === null || q === null) return (p === null) - (q === null) || a.id - b.id;
      return (order.down ? q - p : p - q) || a.id - b.id;
    });
  }

  /** A strip's colours as a gradient with hard edges. */
  function strip(feature) {
    const { bins } = about;
    const stops = [];
    for (let i = 0, j; i < bins; i = j) {
      for (j = i; j < bins && feature.strip[j] === feature.strip[i]; ++j);
      const colour = feature.strip[i] === "." ? "transparent" : csdMarkers.colours[about.states[feature.strip[i]]];
      stops.push(`${colour} ${((100 * i) / bins).toFixed(1)}% ${((100 * j) / bins).toFixed(1)}%`);
    }
    return `linear-gradient(90deg, ${stops.join(", ")})`;
  }

  function row(feature) {
    const state = states.get(feature.id);
    return `<tr data-id="${feature.id}"${feature.id === selected ? ' class="chosen" aria-selected="true"' : ""}>
      <td>${state ? `<span class="state">${csdMarkers.icon(state)}${state}</span>` : '<span class="absent">not here</span>'}</td>
      <td class="number">${feature.id}</td>
      <td title="${csdClock(feature.from)} – ${csdClock(feature.to)}"><span class="strip" style="background-image:${strip(feature)}"></span></td>
      <td class="number">${(100 * columns.seen(feature)).toFixed(0)} %</td>
      <td class="number">${dash(feature.farthest, 1)}</td><td class="number">${dash(feature.speed, 1)}</td>
      <td class="number">${dash(columns.heart(feature), 2)}</td><td class="number">${dash(columns.breath(feature), 2)}</td></tr>`;
  }

  /** Only the rows that are seen are there: an hour can have thousands of features. */
  let told = "";
  function list(anew = false) {
    if (anew || !listed.length) listed = sorted();
    const scroll = $("scroll");
    const first = Math.max(0, Math.floor(scroll.scrollTop / ROW) - 5);
    const end = Math.min(listed.length, first + Math.ceil(scroll.clientHeight / ROW) + 12);
    const space = (rows) => `<tr><td class="space" colspan="8" style="height:${rows * ROW}px"></td></tr>`;
    const text = space(first) + listed.slice(first, end).map(row).join("") + space(listed.length - end);
    if (text === told) return;
    told = text;
    $("rows").innerHTML = text;
    $("count").textContent = `${listed.length === about.features.length ? "" : `${listed.length} of `}${about.features.length}`;
  }

  function reveal(id) {
    const scroll = $("scroll");
    const top = listed.findIndex((f) => f.id === id) * ROW;
    if (top < 0 || (top >= scroll.scrollTop && top + 2 * ROW < scroll.scrollTop + scroll.clientHeight)) return;
    scroll.scrollTop = top - scroll.clientHeight / 2;
  }

  function choose(by) {
    order = { by, down: order.by === by ? !order.down : !["id", "from", "state"].includes(by) };
    for (const head of document.querySelectorAll("#list th"))
      if (head.dataset.by === by) head.setAttribute("aria-sort", order.down ? "descending" : "ascending");
      else head.removeAttribute("aria-sort");
    list(true);
  }

  // ---- the page ----------------------------------------------------------------------------------------------------

  function fit() {
    csdMarkers.fit($("room"), $("stage"), video.videoWidth ? video.videoWidth / video.videoHeight : about.shown[0] / about.shown[1]);
    draw();
    list();
  }

  const KEYS = { " ": toggle, ArrowLeft: () => step(-1), ArrowRight: () => step(1), Escape: () => select(null), i: () => $("ids").click(),
    Home: () => seek(0), End: () => seek(video.duration) };

  function listen() {
    $("play").onclick = toggle;
    $("back").onclick = () => step(-1);
    $("on").onclick = () => step(1);
    $("seek").oninput = () => seek(Number($("seek").value));
    $("speed").onchange = () => (video.playbackRate = Number($("speed").value));
    $("ids").onchange = () => ((overlay.ids = $("ids").checked), draw());
    $("here").onchange = () => list(true);
    $("release").onclick = () => select(null);
    $("scroll").onscroll = () => list();
    $("overlay").onclick = (event) => select(overlay.nearest(event.offsetX, event.offsetY));
    $("rows").onclick = (event) => {
      const found = event.target.closest("tr[data-id]");
      if (found) select(Number(found.dataset.id));
    };
    for (const head of document.querySelectorAll("#list th")) head.onclick = () => choose(head.dataset.by);
    for (const button of document.querySelectorAll("#spans button")) button.onclick = () => plot.zoom(Number(button.dataset.seconds));
    const playing = () => ($("play").textContent = video.paused ? "▶" : "⏸︎");
    video.onplay = video.onpause = playing;
    video.onloadedmetadata = () => {
      $("seek").max = video.duration;
      fit();
    };
    video.onerror = () => csdReport.trouble(new Error(`The browser can't play ${about.video}: ${video.error?.message || "unknown"}`));
    document.onkeydown = (event) => {
      const key = KEYS[event.key];
      if (!key || event.ctrlKey || event.altKey || event.metaKey || event.target.matches("select, input[type=range]")) return;
      if (event.key === " " && event.target.matches("button, input")) return;
      event.preventDefault();
      key();
    };
    new ResizeObserver(fit).observe($("room"));
  }

  /** Called when the index is there. */
  csdReport.start = () => {
    about = csdReport.about;
    overlay = new csdMarkers.Overlay($("overlay"), about);
    plot = new CsdPlot(about, seek);
    $("facts").textContent = [`${about.frames} frames of ${about.width}×${about.height}`, csdClock(about.end - about.begin, 1), about.algorithm,
      about.role === "truth" ? "truth" : about.tracks, ...about.notes].join(" · ");
    $("facts").title = $("facts").textContent;
    $("legend").innerHTML = csdMarkers.legend();
    listen();
    fit();
    choose("id");
    select(null);
    plot.told();
    // Of a clock the frame that began last: half an interval is taken off, for frameAt() rounds to the nearest.
    csdMarkers.watch(video, show, about.interval / 2);
    if (video.readyState >= HTMLMediaElement.HAVE_METADATA) video.onloadedmetadata();
    if (video.readyState >= HTMLMediaElement.HAVE_CURRENT_DATA) show(video.currentTime);
    else video.addEventListener("loadeddata", () => show(video.currentTime), { once: true });
  };

  /** What the page shows, for scripts that drive it (docs/report.md). */
  csdReport.state = () => ({
    time: shown.time,
    frame: shown.frame ? shown.frame.number : null,
    pending: Boolean(shown.pending),
    selected,
    drawn: overlay.features.map((feature) => {
      const [left, top] = overlay.at(feature.x, feature.y);
      return { ...feature, left, top };
    }),
    curve: plot.rows,
    chunks: csdReport.tracksChunks.there.size + csdReport.motionChunks.there.size,
  });
  csdReport.select = select;
  csdReport.seek = seek;
})();
