"use strict";
// The explorers of a page: each reads its data from the element "ID-data" and draws on its two canvases.
(() => {
  const TURN = 2 * Math.PI;
  const TOP = 65535;
  const LOG_DECADES = 6; // the powers of ten that logarithmic colours tell apart

  /** The densities of a case at a snapshot; see figures/src/explorer/quantised.rs for the numbers. */
  function decode(text, peak, decades) {
    const bytes = Uint8Array.from(atob(text), letter => letter.charCodeAt(0));
    const steps = new DataView(bytes.buffer);
    const values = new Float64Array(bytes.length / 2);
    for (let i = 0; i < values.length; i++) {
      const q = steps.getUint16(2 * i, true);
      values[i] = q === 0 ? 0 : peak * 10 ** (-decades * (1 - (q - 1) / (TOP - 1)));
    }
    return values;
  }

  function palette(text) {
    return Uint8Array.from(atob(text), letter => letter.charCodeAt(0));
  }

  /** A number with four digits that count. */
  function written(value) {
    if (value === 0 || !Number.isFinite(value)) return String(value);
    const size = Math.abs(value);
    const text = size >= 1e-3 && size < 1e5 ? String(Number(value.toPrecision(4))) : value.toExponential(3);
    return text.replace("-", "−");
  }

  /** Round numbers between two ends, about `count` of them. */
  function ticks(low, high, count) {
    const raw = (high - low) / count;
    const unit = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].find(factor => factor * unit >= raw) * unit;
    const found = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(k * step);
    const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    return found.map(at => ({ at, text: at.toFixed(digits).replace("-", "−") }));
  }

  /** The value of a curve at a time, on the line between its neighbours; null where one of them is not given. */
  function between(times, values, t) {
    const after = times.findIndex(time => time >= t - 1e-12);
    if (after < 0) return values.at(-1);
    if (after === 0 || Math.abs(times[after] - t) < 1e-12) return values[after];
    const [low, high] = [values[after - 1], values[after]];
    if (low === null || high === null) return null;
    return low + (t - times[after - 1]) / (times[after] - times[after - 1]) * (high - low);
  }

  function colour(name) {
    return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  }

  function isDark() {
    return matchMedia("(prefers-color-scheme: dark)").matches;
  }

  /** A drawing surface in CSS pixels with a frame for axes. */
  class Plot {
    constructor(canvas, x, y) {
      const { width, height } = canvas.getBoundingClientRect();
      const scale = devicePixelRatio || 1;
      [canvas.width, canvas.height] = [Math.round(width * scale), Math.round(height * scale)];
      this.pen = canvas.getContext("2d");
      this.pen.scale(scale, scale);
      this.pen.font = "12px Arial, 'Liberation Sans', sans-serif";
      [this.left, this.right, this.top, this.bottom] = [64, width - 14, 10, height - 42];
      [this.x, this.y] = [x, y];
    }
    across(x) { return this.left + (x - this.x[0]) / (this.x[1] - this.x[0]) * (this.right - this.left); }
    up(y) { return this.bottom - (y - this.y[0]) / (this.y[1] - this.y[0]) * (this.bottom - this.top); }
    value(px, py) {
      return [
        this.x[0] + (px - this.left) / (this.right - this.left) * (this.x[1] - this.x[0]),
        this.y[0] + (this.bottom - py) / (this.bottom - this.top) * (this.y[1] - this.y[0]),
      ];
    }
    line(from, to, ink, dashes = []) {
      this.pen.strokeStyle = ink;
      this.pen.setLineDash(dashes);
      this.pen.beginPath();
      this.pen.moveTo(...from);
      this.pen.lineTo(...to);
      this.pen.stroke();
      this.pen.setLineDash([]);
    }
    /** Everything that `draw` draws is cut off at the frame. */
    inside(draw, from = this.left, to = this.right) {
      this.pen.save();
      this.pen.beginPath();
      this.pen.rect(from, this.top, to - from, this.bottom - this.top);
      this.pen.clip();
      draw();
      this.pen.restore();
    }
    axes(xLabel, yLabel) {
      const { pen } = this;
      const [text, faint] = [colour("--text"), colour("--line")];
      pen.fillStyle = text;
      pen.lineWidth = 1;
      pen.textBaseline = "top";
      pen.textAlign = "center";
      for (const { at, text: words } of ticks(...this.x, Math.max(2, (this.right - this.left) / 90))) {
        const px = this.across(at);
        this.line([px, this.bottom], [px, this.bottom + 4], text);
        pen.fillText(words, px, this.bottom + 7);
      }
      pen.fillText(xLabel, (this.left + this.right) / 2, this.bottom + 25);
      pen.textBaseline = "middle";
      pen.textAlign = "right";
      for (const { at, text: words } of ticks(...this.y, Math.max(2, (this.bottom - this.top) / 50))) {
        const py = this.up(at);
        this.line([this.left - 4, py], [this.left, py], text);
        pen.fillText(words, this.left - 7, py);
      }
      pen.save();
      pen.translate(12, (this.top + this.bottom) / 2);
      pen.rotate(-Math.PI / 2);
      pen.textAlign = "center";
      pen.fillText(yLabel, 0, 0);
      pen.restore();
      pen.strokeStyle = faint;
      pen.strokeRect(this.left, this.top, this.right - this.left, this.bottom - this.top);
    }
  }

  class Explorer {
    constructor(root) {
      this.root = root;
      this.data = JSON.parse(document.getElementById(`${root.id}-data`).textContent);
      this.palettes = { ramp: palette(this.data.ramp), divergence: palette(this.data.divergence) };
      this.decoded = new Map();
      [this.cross, this.cursor] = [null, null];
      this.map = root.querySelector("canvas.map");
      this.curves = root.querySelector("canvas.curves");
      root.hidden = false;
      root.parentElement.classList.add("live");
      root.addEventListener("input", event => {
        if (event.target.name === "time") this.cursor = null;
        this.draw();
      });
      this.map.addEventListener("pointermove", event => this.point(event));
      this.map.addEventListener("pointerdown", event => this.point(event));
      this.map.addEventListener("keydown", event => this.step(event));
      if (this.curves) {
        for (const kind of ["pointermove", "pointerdown"]) this.curves.addEventListener(kind, event => this.pointAtTime(event));
        this.curves.addEventListener("keydown", event => this.stepTime(event));
      }
      this.draw();
      new ResizeObserver(() => this.draw()).observe(this.map);
      matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
    }

    control(name) { return this.root.querySelector(`[name="${name}"], [data-name="${name}"]`); }
    get snapshot() { return Number(this.control("time").value); }
    get pair() { return this.data.pairs[this.control("pair")?.selectedIndex ?? 0]; }
    get chosen() { return ["a", "b"].map(name => this.control(name).selectedIndex); }
    get isDifference() { return this.root.querySelector("[type=radio][value=difference]").checked; }
    get divide() { return Number(this.control("divide").value) / 1000; }

    /** The grid and the values of a case at the snapshot that is shown; null if it withholds them. */
    density(index) {
      const { pair, snapshot } = this;
      const at = pair.snapshots[snapshot];
      const stored = at.cases[index];
      if (!stored) return null;
      const key = `${this.data.pairs.indexOf(pair)} ${snapshot} ${index}`;
      if (!this.decoded.has(key)) {
        this.decoded.set(key, { grid: stored.grid, values: decode(stored.q, at.peak, this.data.decades) });
      }
      return this.decoded.get(key);
    }

    /** The value of a density at a place, and the bin's number; null outside the grid. */
    read(density, [x, y]) {
      if (!density) return null;
      const [[xLow, xHigh, nx], [yLow, yHigh, ny]] = density.grid;
      if (this.pair.is_circle) x -= TURN * Math.floor((x - xLow) / TURN);
      const i = Math.floor((x - xLow) / (xHigh - xLow) * nx);
      const j = Math.floor((y - yLow) / (yHigh - yLow) * ny);
      if (i < 0 || i >= nx || j < 0 || j >= ny) return null;
      return density.values[i * ny + j];
    }

    difference(one, other) {
      if (!one || !other || JSON.stringify(one.grid) !== JSON.stringify(other.grid)) return null;
      return { grid: one.grid, values: one.values.map((value, k) => value - other.values[k]) };
    }

    /** A picture of an array, one pixel per bin; `position` is its place on the palette from 0 to 1, or null for nothing. */
    picture({ grid, values }, colours, position, opacity) {
      const [[, , nx], [, , ny]] = grid;
      const canvas = new OffscreenCanvas(nx, ny);
      const image = new ImageData(nx, ny);
      const last = colours.length / 3 - 1;
      for (let i = 0; i < nx; i++) {
        for (let j = 0; j < ny; j++) {
          const at = position(values[i * ny + j]);
          if (at === null) continue;
          const [from, to] = [3 * Math.round(last * Math.min(1, Math.max(0, at))), 4 * ((ny - 1 - j) * nx + i)];
          image.data.set([colours[from], colours[from + 1], colours[from + 2], 255 * opacity(at)], to);
        }
      }
      canvas.getContext("2d").putImageData(image, 0, 0);
      return canvas;
    }

    place(plot, picture, [[xLow, xHigh], [yLow, yHigh]]) {
      plot.pen.imageSmoothingEnabled = false;
      const turns = this.pair.is_circle ? [-2, -1, 0, 1, 2] : [0];
      for (const turn of turns) {
        const [left, right] = [xLow, xHigh].map(x => plot.across(x + turn * TURN));
        const [top, bottom] = [yHigh, yLow].map(y => plot.up(y));
        plot.pen.drawImage(picture, left, top, right - left, bottom - top);
      }
    }

    draw() {
      const { pair, snapshot, data } = this;
      this.control("t").textContent = `t = ${written(data.times[snapshot])} yr`;
      this.root.querySelector(".divider").style.visibility = this.isDifference ? "hidden" : "visible";
      const frame = this.control("whole").checked ? pair.frame : pair.snapshots[snapshot].frame;
      const plot = new Plot(this.map, frame.slice(0, 2), frame.slice(2));
      this.plot = plot;
      if (this.isDifference) this.drawDifference(plot); else this.drawSwipe(plot);
      plot.axes(...pair.labels);
      this.drawCritical(plot);
      this.drawCross(plot);
      this.tell();
      if (this.curves) this.drawCurves();
    }

    drawSwipe(plot) {
      const peak = this.pair.snapshots[this.snapshot].peak;
      const isLog = this.control("log").checked;
      const least = isLog ? 10 ** -LOG_DECADES : 1e-3;
      const position = value => {
        if (!(peak > 0 && value >= least * peak)) return null;
        return isLog ? 1 + Math.log10(value / peak) / LOG_DECADES : value / peak;
      };
      const border = plot.left + this.divide * (plot.right - plot.left);
      const sides = [[plot.left, border], [border, plot.right]];
      const labels = this.chosen.map(index => this.data.cases[index].label);
      this.chosen.forEach((index, side) => {
        const density = this.density(index);
        if (density) {
          const picture = this.picture(density, this.palettes.ramp, position, () => 1);
          plot.inside(() => this.place(plot, picture, density.grid), ...sides[side]);
        }
        this.name(plot, density ? labels[side] : `${labels[side]}: withheld`, side, border);
      });
      plot.line([border, plot.top], [border, plot.bottom], colour("--text"));
      this.showScale("ramp", isLog ? peak * 10 ** -LOG_DECADES : 0, peak, isLog ? ", logarithmic" : "");
      this.map.setAttribute("aria-label", `Density at ${this.control("t").textContent}: ${labels[0]} left of the divider, ${labels[1]} right of it`);
    }

    /** Writes the name of a case into its side of the map. */
    name(plot, text, side, border) {
      plot.pen.fillStyle = colour("--text");
      plot.pen.textBaseline = "top";
      plot.pen.textAlign = side === 0 ? "right" : "left";
      plot.inside(() => plot.pen.fillText(text, border + (side === 0 ? -8 : 8), plot.top + 6));
    }

    drawDifference(plot) {
      const [a, b] = this.chosen;
      const [one, other] = [this.density(a), this.density(b)];
      const labels = [a, b].map(index => this.data.cases[index].label);
      const difference = this.difference(one, other);
      if (!difference) {
        const why = one && other ? "their bins differ" : "withheld";
        this.name(plot, `${labels.join(" − ")}: ${why}`, 1, plot.left);
        this.showScale("divergence", 0, 0, "");
      } else {
        const limit = difference.values.reduce((most, value) => Math.max(most, Math.abs(value)), 0);
        const position = value => limit > 0 ? 0.5 + 0.5 * value / limit : null;
        const picture = this.picture(difference, this.palettes.divergence, position, at => Math.min(1, 2 * Math.abs(2 * at - 1)));
        plot.inside(() => this.place(plot, picture, difference.grid));
        this.name(plot, labels.join(" − "), 1, plot.left);
        this.showScale("divergence", -limit, limit, "");
      }
      this.map.setAttribute("aria-label", `Density of ${labels[0]} minus that of ${labels[1]} at ${this.control("t").textContent}`);
    }

    showScale(name, low, high, words) {
      const colours = this.palettes[name];
      const canvas = this.root.querySelector("canvas.ramp");
      [canvas.width, canvas.height] = [colours.length / 3, 1];
      const image = new ImageData(canvas.width, 1);
      for (let k = 0; k < canvas.width; k++) image.data.set([...colours.slice(3 * k, 3 * k + 3), 255], 4 * k);
      canvas.getContext("2d").putImageData(image, 0, 0);
      this.control("low").textContent = written(low);
      this.control("high").textContent = written(high);
      this.control("unit").textContent = this.pair.density + words;
    }

    drawCritical(plot) {
      const { critical, pairs } = this.data;
      const axis = this.pair.critical_axis;
      if (axis === null) return;
      const ink = colour("--warn");
      plot.inside(() => {
        if (axis === 1) plot.line([plot.left, plot.up(critical.value)], [plot.right, plot.up(critical.value)], ink, [6, 3]);
        else plot.line([plot.across(critical.value), plot.top], [plot.across(critical.value), plot.bottom], ink, [6, 3]);
      });
    }

    drawCross(plot) {
      if (!this.cross) return;
      const [px, py] = [plot.across(this.cross[0]), plot.up(this.cross[1])];
      plot.inside(() => {
        plot.line([px, plot.top], [px, plot.bottom], colour("--faint"), [2, 3]);
        plot.line([plot.left, py], [plot.right, py], colour("--faint"), [2, 3]);
      });
    }

    /** Writes the values at the cross. */
    tell() {
      if (!this.cross) return;
      const { pair } = this;
      const place = [0, 1].map(k => `${pair.symbols[k]} = ${written(this.cross[k])}${pair.units[k] ? " " + pair.units[k] : ""}`);
      const values = this.chosen.map(index => this.read(this.density(index), this.cross));
      const named = this.chosen.map((index, k) => `${this.data.cases[index].label} ${values[k] === null ? "states nothing here" : written(values[k])}`);
      let text = `${place.join(", ")}: ${named.join(", ")}`;
      if (values.every(value => value !== null)) {
        const difference = values[0] - values[1];
        text += `, difference ${written(difference)}`;
        if (values[1] > 0) text += ` (${written(100 * difference / values[1])} %)`;
      }
      this.root.querySelector(".values").textContent = `${text}; each is the mean of the ${pair.density} over a bin.`;
    }

    point(event) {
      const box = this.map.getBoundingClientRect();
      const [px, py] = [event.clientX - box.left, event.clientY - box.top];
      const { plot } = this;
      if (px < plot.left || px > plot.right || py < plot.top || py > plot.bottom) return;
      this.cross = plot.value(px, py);
      this.draw();
    }

    /** Moves the cross by a bin, or by ten with Shift. */
    step(event) {
      const moves = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
      const move = moves[event.key];
      if (!move) return;
      event.preventDefault();
      const { plot } = this;
      const density = this.chosen.map(index => this.density(index)).find(Boolean);
      const axes = [plot.x, plot.y];
      this.cross ??= axes.map(([low, high]) => (low + high) / 2);
      this.cross = this.cross.map((value, k) => {
        const [low, high, bins] = density ? density.grid[k] : [...axes[k], 100];
        const moved = value + move[k] * (event.shiftKey ? 10 : 1) * (high - low) / bins;
        return Math.min(axes[k][1], Math.max(axes[k][0], moved));
      });
      this.draw();
    }

    get time() { return this.cursor ?? this.data.times[this.snapshot]; }

    pointAtTime(event) {
      const box = this.curves.getBoundingClientRect();
      const [t] = this.curvePlot.value(event.clientX - box.left, 0);
      const end = this.data.times.at(-1);
      this.cursor = Math.min(end, Math.max(0, t));
      this.drawCurves();
    }

    stepTime(event) {
      const moves = { ArrowLeft: -1, ArrowRight: 1, Home: -Infinity, End: Infinity };
      const move = moves[event.key];
      if (!move) return;
      event.preventDefault();
      const end = this.data.times.at(-1);
      this.cursor = Math.min(end, Math.max(0, this.time + move * (event.shiftKey ? 0.1 : 0.01) * end));
      this.drawCurves();
    }

    drawCurves() {
      const { critical, times } = this.data;
      const cases = this.data.cases.filter(one => one.passage.t.length > 0);
      const most = Math.max(1e-12, ...cases.flatMap(one => [...one.passage.p, ...one.passage.high].filter(p => p !== null)));
      const plot = new Plot(this.curves, [0, times.at(-1)], [0, 1.04 * most]);
      this.curvePlot = plot;
      const shade = isDark() ? 1 : 0;
      for (const one of cases) {
        const { t, p, low, high } = one.passage;
        plot.inside(() => {
          const { pen } = plot;
          [pen.strokeStyle, pen.fillStyle, pen.lineWidth] = [one.colours[shade], one.colours[shade], 1.6];
          const band = t.map((_, k) => k).filter(k => low[k] !== null && high[k] !== null);
          pen.globalAlpha = 0.15;
          pen.beginPath();
          for (const k of band) pen.lineTo(plot.across(t[k]), plot.up(high[k]));
          for (const k of band.reverse()) pen.lineTo(plot.across(t[k]), plot.up(low[k]));
          pen.fill();
          pen.globalAlpha = 1;
          pen.setLineDash(one.dashes);
          pen.beginPath();
          let isDown = false;
          t.forEach((time, k) => {
            if (p[k] === null) { isDown = false; return; }
            pen[isDown ? "lineTo" : "moveTo"](plot.across(time), plot.up(p[k]));
            isDown = true;
          });
          pen.stroke();
          pen.setLineDash([]);
        });
      }
      plot.axes("time t [yr]", `P(${critical.symbol} has reached ${written(critical.value)})`);
      const at = plot.across(this.time);
      plot.line([at, plot.top], [at, plot.bottom], colour("--warn"));
      this.tabulate(cases);
      this.curves.setAttribute("aria-label", `Probability of having reached ${critical.name} ${written(critical.value)} against time; the cursor is at ${written(this.time)} yr`);
    }

    /** Writes the probabilities at the cursor, between two times of a curve on the straight line that is drawn there. */
    tabulate(cases) {
      const table = this.root.querySelector("table");
      const { critical } = this.data;
      table.caption.textContent = `Probability of having reached ${critical.symbol} = ${written(critical.value)} by t = ${written(this.time)} yr`;
      const rows = cases.map(({ label, passage }) => {
        const row = document.createElement("tr");
        const cell = (tag, text) => row.appendChild(Object.assign(document.createElement(tag), { textContent: text }));
        const [p, low, high] = [passage.p, passage.low, passage.high].map(values => between(passage.t, values, this.time));
        const isWide = low !== null && high !== null && high - low > 1e-6;
        cell("th", label).scope = "row";
        cell("td", p === null ? "withheld" : written(p));
        cell("td", isWide ? `${written(low)} to ${written(high)}${passage.interval ? ` (${passage.interval})` : ""}` : "–");
        return row;
      });
      table.tBodies[0].replaceChildren(...rows);
    }
  }

  for (const root of document.querySelectorAll(".explorer")) new Explorer(root);
})();
