// SPDX-License-Identifier: LGPL-2.1-or-later
// Displacement over time, by dygraphs.
"use strict";

class CsdPlot {
  /** seek(s): called where the curve is clicked. */
  constructor(about, seek) {
    Object.assign(this, { about, seek, graph: null, span: 10 });
    this.cursor = document.getElementById("cursor");
    this.place = document.getElementById("graph");
    this.values = document.getElementById("values");
    new ResizeObserver(() => this.graph && (this.graph.resize(), this.move(this.time ?? about.begin))).observe(this.place);
  }

  /** motion: {first, dx, dy}; times: of all frames, s. */
  show(motion, times) {
    const rows = [];
    for (let i = 0; i < motion.dx.length; ++i) {
      const time = times[motion.first + i];
      if (!Number.isNaN(time)) rows.push([time, Number.isNaN(motion.dx[i]) ? null : motion.dx[i], Number.isNaN(motion.dy[i]) ? null : motion.dy[i]]);
    }
    this.rows = rows;
    if (this.graph) this.graph.destroy();
    this.graph = null; // the new one draws before it is there
    const styles = getComputedStyle(document.documentElement);
    const colour = (name) => styles.getPropertyValue(`--${name}`).trim();
    const clock = (time) => csdClock(time, this.span && this.span < 5 ? 2 : 1);
    this.graph = new Dygraph(this.place, rows.length ? rows : [[this.about.begin, null, null]], {
      labels: ["time", "x", "y"], colors: [colour("x"), colour("y")], strokeWidth: 1.4, strokePattern: null,
      series: { y: { strokePattern: [5, 2] } }, // not by colour alone
      ylabel: "displacement, px", legend: "never", connectSeparatedPoints: false,
      gridLineColor: colour("line"), axisLineColor: colour("line"), axisLabelFontSize: 11, axisLabelWidth: 52,
      axes: { x: { axisLabelFormatter: clock, valueFormatter: clock, pixelsPerLabel: 70 }, y: { axisLabelWidth: 40 } },
      showRangeSelector: true, rangeSelectorHeight: 24, rangeSelectorAlpha: 0.3, rangeSelectorPlotFillColor: "#3a4450", rangeSelectorPlotStrokeColor: "#7f8b99",
      rangeSelectorBackgroundStrokeColor: colour("line"), rangeSelectorForegroundStrokeColor: "#9aa4b0",
      xRangePad: 0, dateWindow: this.window(this.time ?? this.about.begin), animatedZooms: false, highlightCircleSize: 3,
      clickCallback: (_event, time) => this.seek(time),
      zoomCallback: () => (this.span = null, this.told(), this.move(this.time)),
      drawCallback: () => this.move(this.time ?? this.about.begin, true),
    });
    this.move(this.time ?? this.about.begin);
  }

  /** What is to be seen around a time. */
  window(time) {
    const { begin, end } = this.about;
    if (!this.span || end - begin <= this.span) return [begin, Math.max(end, begin + 0.1)];
    const from = Math.min(Math.max(time - 0.25 * this.span, begin), end - this.span);
    return [from, from + this.span];
  }

  /** seconds: how much is seen; 0: all. */
  zoom(seconds) {
    this.span = seconds;
    this.told();
    if (this.graph) this.graph.updateOptions({ dateWindow: this.window(this.time ?? this.about.begin) });
  }

  told() {
    for (const button of document.querySelectorAll("#spans button"))
      button.classList.toggle("chosen", this.span !== null && Number(button.dataset.seconds) === this.span);
  }

  /** Puts the cursor at a time; the curve follows it. */
  move(time, drawing = false) {
    this.time = time;
    if (!this.graph || time === undefined) return;
    const [from, to] = this.graph.xAxisRange();
    if (!drawing && (time < from || time > to) && this.span !== 0) {
      const width = to - from;
      const { begin, end } = this.about;
      const start = Math.max(begin, Math.min(time - 0.1 * width, end - width));
      if (Math.abs(start - from) > 1e-6) this.graph.updateOptions({ dateWindow: [start, start + width] });
      return;
    }
    const area = this.graph.getArea();
    const x = this.graph.toDomXCoord(time);
    this.cursor.hidden = x < area.x || x > area.x + area.w;
    this.cursor.style.left = `${this.place.offsetLeft + x}px`;
    this.cursor.style.height = `${area.h}px`;
    const row = this.rowAt(time);
    const known = row && row[1] !== null && Math.abs(row[0] - time) < this.about.interval;
    this.values.innerHTML = `<b class="x">— x</b> ${known ? row[1].toFixed(2) : "–"} &nbsp; <b class="y">┄ y</b> ${known ? row[2].toFixed(2) : "–"} px`;
  }

  /** The last row that isn't after a time. */
  rowAt(time) {
    let low = 0, high = this.rows.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.rows[middle][0] <= time + this.about.interval / 2) low = middle + 1;
      else high = middle;
    }
    return this.rows[low - 1];
  }
}

/** 1:02:03.4 */
function csdClock(seconds, digits = 2) {
  if (!(seconds >= 0)) seconds = 0;
  const unit = 10 ** digits;
  const whole = Math.round(seconds * unit);
  const parts = [Math.floor(whole / unit / 3600), Math.floor(whole / unit / 60) % 60, (whole / unit) % 60];
  const rest = parts[2].toFixed(digits).padStart(digits ? digits + 3 : 2, "0");
  return parts[0] ? `${parts[0]}:${String(parts[1]).padStart(2, "0")}:${rest}` : `${parts[1]}:${rest}`;
}
