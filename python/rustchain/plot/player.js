// The player of a recorded motion: a canvas with the moving bodies, and plots linked to its time.
// It builds itself into every <div class="player">, whose data is the JSON of the script inside. Each player of a page
// may stand before a copy of this script: what another copy has built stays as it is.
"use strict";
(() => {
  const STYLE = `
.player { --gap: 8px; font: 14px/1.4 system-ui, sans-serif; color: var(--ink); margin: 0 0 1em; }
.player canvas { display: block; width: 100%; border: 1px solid var(--line); border-radius: 6px;
  background: var(--paper); touch-action: none; }
.player canvas:focus-visible, .player button:focus-visible, .player select:focus-visible,
.player input:focus-visible { outline: 2px solid var(--accent); outline-offset: 1px; }
.player .stage { height: clamp(220px, 46vw, 520px); cursor: grab; }
.player .chart { height: 200px; cursor: crosshair; margin-top: var(--gap); touch-action: pan-y; }
.player .bar { display: flex; flex-wrap: wrap; gap: var(--gap); align-items: center; margin: var(--gap) 0; }
.player .bar input[type=range] { flex: 1 1 100%; min-width: 0; accent-color: var(--accent); }
.player button, .player select { font: inherit; color: inherit; background: var(--soft);
  border: 1px solid var(--line); border-radius: 6px; padding: 5px 10px; min-height: 34px; }
.player output { font-variant-numeric: tabular-nums; min-width: 7.5em; }
.player .told { min-height: 4.4em; font-variant-numeric: tabular-nums; white-space: pre-line; }
.player .keys, .player .legend { color: var(--dim); font-size: 12.5px; }
.player .legend span { margin-right: 1.2em; white-space: nowrap; }
.player .legend i { display: inline-block; width: 1.4em; height: 3px; margin-right: .4em; print-color-adjust: exact;
  vertical-align: middle; }
@media (max-width: 640px) { .player .keys { display: none; } }`;

  const HEAD = 30; // [pixels] of the stage that the scales take

  const inflate = async (text) => {
    const binary = atob(text), bytes = new Uint8Array(binary.length);
    for (let i = 0; i < bytes.length; i++) bytes[i] = binary.charCodeAt(i);
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  };

  // Whole numbers, stored as differences along time in four planes of bytes.
  const decode = async (block) => {
    const { rows, channels, scale, offset } = block;
    const planes = await inflate(block.data), n = rows * channels, whole = new Int32Array(n);
    for (let i = 0; i < n; i++) {
      const z = planes[i] | (planes[n + i] << 8) | (planes[2 * n + i] << 16) | (planes[3 * n + i] << 24);
      whole[i] = (z >>> 1) ^ -(z & 1);
    }
    for (let pass = 0; pass < block.order; pass++)
      for (let c = 0; c < channels; c++)
        for (let i = c * rows + 1; i < (c + 1) * rows; i++) whole[i] += whole[i - 1];
    return {
      channels,
      at: (channel, row, share) => {
        const i = channel * rows + row, here = whole[i];
        return offset + scale * (share ? here + share * (whole[i + 1] - here) : here);
      },
    };
  };

  const format = (value, digits = 3) => {
    if (!Number.isFinite(value)) return "–";
    const text = Math.abs(value) >= 1e6 || (value && Math.abs(value) < 1e-3)
      ? value.toExponential(digits - 1) : String(Number(value.toPrecision(digits + 1)));
    return text.replace("-", "−");
  };

  const element = (tag, attributes = {}, ...children) => {
    const made = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    made.append(...children);
    return made;
  };

  const niceStep = (span, most) => {
    const power = 10 ** Math.floor(Math.log10(span / most));
    return [1, 2, 5, 10].map((k) => k * power).find((step) => span / step <= most);
  };

  async function player(root) {
    const data = JSON.parse(root.querySelector("script").textContent);
    const { names, shapes } = data;
    const blocks = await Promise.all([data.time, data.places, data.angles].map(decode));
    const [clock, places, angles] = blocks;
    const rows = data.time.rows;
    const times = Float64Array.from({ length: rows }, (_, row) => clock.at(0, row, 0));
    const series = await decode(data.series.block);
    for (const group of data.forces) group.vectors = await decode(group.block);
    for (const shape of shapes) {
      if (!shape.outline) continue;
      shape.path = new Path2D();
      for (let i = 0; i < shape.outline.length; i += 2)
        shape.path[i ? "lineTo" : "moveTo"](shape.outline[i], shape.outline[i + 1]);
      if (shape.closed) shape.path.closePath();
    }

    // --- what is shown
    const state = {
      time: times[0], playing: false, slow: data.slow, follow: data.follow, hovered: -1, selected: -1,
      view: { x: data.view.x, y: data.view.y, width: data.view.width, height: data.view.height },
      span: [times[0], times[rows - 1]],
    };
    const stage = element("canvas", { class: "stage", tabindex: "0", role: "img",
      "aria-label": `Moving bodies of ${data.name}. Space plays, arrow keys step, plus and minus zoom.` });
    const chart = element("canvas", { class: "chart", tabindex: "0", role: "img",
      "aria-label": "Forces over time; the line is the time shown." });
    const slider = element("input", { type: "range", min: 0, max: rows - 1, step: 1, value: 0,
      "aria-label": "time" });
    const play = element("button", { type: "button", "aria-label": "play" }, "▶");
    const readout = element("output");
    const speed = element("select", { "aria-label": "slow motion" });
    for (const slow of [...new Set([1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, data.slow])].sort((a, b) => a - b))
      speed.append(element("option", { value: slow }, slow === 1 ? "real time" : `1 : ${format(slow, 2)}`));
    speed.value = String(data.slow);
    const camera = element("select", { "aria-label": "camera" }, element("option", { value: -1 }, "whole scene"));
    names.forEach((name, k) => camera.append(element("option", { value: k }, name.replace("_", " "))));
    camera.value = String(data.follow);
    const fit = element("button", { type: "button" }, "fit");
    const switches = data.forces.map((group) => {
      const box = element("input", { type: "checkbox" });
      box.checked = true;
      group.shown = () => box.checked;
      return element("label", {}, box, ` ${group.label}`);
    });
    const told = element("div", { class: "told", "aria-live": "polite" });
    const legend = element("div", { class: "legend" });
    const keys = element("div", { class: "keys" },
      "space: play · ← →: a row (with shift: a hundredth) · home, end · ↑ ↓: speed · + −: zoom · 0: fit · drag, wheel, pinch");
    root.append(stage, element("div", { class: "bar" }, slider, play, readout, speed, camera, fit, ...switches),
      told, chart, legend, keys);

    // --- where everything is
    const place = (time) => {
      let low = 0, high = rows - 1;
      while (high - low > 1) {
        const middle = (low + high) >> 1;
        if (times[middle] <= time) low = middle; else high = middle;
      }
      const step = times[high] - times[low];
      const share = step > 0 ? Math.min(1, Math.max(0, (time - times[low]) / step)) : 0;
      return [low, share];
    };
    const pose = (body, row, share) => body < 0 ? [0, 0, 0]
      : [places.at(2 * body, row, share), places.at(2 * body + 1, row, share), angles.at(body, row, share)];
    const point = (body, at, row, share) => {
      const [x, y, angle] = pose(body, row, share), c = Math.cos(angle), s = Math.sin(angle);
      return [x + c * at[0] - s * at[1], y + s * at[0] + c * at[1]];
    };
    const size = (canvas) => {
      const ratio = window.devicePixelRatio || 1;
      const width = Math.round(canvas.clientWidth * ratio), height = Math.round(canvas.clientHeight * ratio);
      if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
      return [width, height, ratio];
    };
    const theme = () => document.documentElement.dataset.theme
      || (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
    const color = (name) => getComputedStyle(root).getPropertyValue(name).trim();
    const window_ = () => {
      const [width, height, ratio] = size(stage), view = state.view, head = HEAD * ratio;
      const scale = Math.min(width / view.width, (height - head) / view.height);
      const cx = width / 2, cy = (height + head) / 2;
      const [row, share] = place(state.time);
      const [fx, fy] = state.follow < 0 ? [0, 0] : pose(state.follow, row, share);
      return { scale, cx, cy, x: cx - scale * (view.x + fx), y: cy + scale * (view.y + fy), row, share, width, height };
    };
    const into = (draw, at, [x, y, angle]) => {
      const c = Math.cos(angle) * at.scale, s = Math.sin(angle) * at.scale;
      draw.setTransform(c, -s, -s, -c, at.x + at.scale * x, at.y - at.scale * y);
    };

    const arrow = (draw, at, [x, y], [fx, fy], width) => {
      const length = Math.hypot(fx, fy);
      if (!(length > 0)) return;
      const [ux, uy] = [fx / length, fy / length], head = Math.min(2.4 * width, 0.6 * length), half = head / 2.4;
      const corner = (along, across) => draw.lineTo(at.x + at.scale * (x + ux * along - uy * across),
        at.y - at.scale * (y + uy * along + ux * across));
      draw.beginPath();
      corner(0, 0.3 * half); corner(length - head, 0.3 * half); corner(length - head, half); corner(length, 0);
      corner(length - head, -half); corner(length - head, -0.3 * half); corner(0, -0.3 * half);
      draw.closePath();
      draw.fill();
    };

    const drawBar = (draw, at, shape) => {
      const [[x0, y0], [x1, y1]] = shape.bodies.map((body, k) => point(body, shape.points[k], at.row, at.share))
        .map(([x, y]) => [at.x + at.scale * x, at.y - at.scale * y]);
      draw.setTransform(1, 0, 0, 1, 0, 0);
      draw.beginPath();
      draw.moveTo(x0, y0);
      const across = Math.hypot(x1 - x0, y1 - y0) || 1, width = at.scale * shape.width;
      if (shape.kind === "spring")
        for (let k = 0; k <= 8; k++) {
          const share = 0.2 + 0.6 * k / 8, side = (k % 2 ? -0.5 : 0.5) * width / across;
          draw.lineTo(x0 + share * (x1 - x0) - side * (y1 - y0), y0 + share * (y1 - y0) + side * (x1 - x0));
        }
      draw.lineTo(x1, y1);
      return width;
    };

    const drawStage = () => {
      const at = window_(), draw = stage.getContext("2d"), looks = data.looks[theme()];
      const ratio = window.devicePixelRatio || 1, thin = 0.9 * ratio;
      draw.setTransform(1, 0, 0, 1, 0, 0);
      draw.clearRect(0, 0, at.width, at.height);
      draw.lineJoin = draw.lineCap = "round";
      for (const shape of shapes) {
        const [face, opacity, edge] = looks[shape.kind];
        draw.strokeStyle = edge;
        if (!shape.path) {
          const width = drawBar(draw, at, shape);
          draw.lineWidth = shape.kind === "spring" ? 1.3 * ratio : width;
          draw.stroke();
          if (shape.kind !== "spring") { draw.strokeStyle = face; draw.lineWidth = Math.max(width - 2 * thin, thin); draw.stroke(); }
          continue;
        }
        draw.lineWidth = thin / at.scale;
        for (const body of shape.bodies) {
          into(draw, at, pose(body, at.row, at.share));
          if (face && shape.closed) {
            draw.globalAlpha = opacity;
            draw.fillStyle = face;
            draw.fill(shape.path);
            draw.globalAlpha = 1;
          }
          draw.stroke(shape.path);
        }
      }
      const mark = state.hovered >= 0 ? state.hovered : state.selected;
      for (const shape of mark >= 0 ? shapes.filter((one) => one.path && one.solid && one.bodies.includes(mark)) : []) {
        into(draw, at, pose(mark, at.row, at.share));
        draw.strokeStyle = color("--accent");
        draw.lineWidth = 2.5 * ratio / at.scale;
        draw.stroke(shape.path);
      }
      draw.setTransform(1, 0, 0, 1, 0, 0);
      for (const group of data.forces) {
        if (!group.shown()) continue;
        draw.fillStyle = data.colors[theme()][group.kind];
        group.bodies.forEach((body, k) => {
          const force = [group.vectors.at(2 * k, at.row, at.share), group.vectors.at(2 * k + 1, at.row, at.share)];
          arrow(draw, at, point(body, group.points[k], at.row, at.share), force.map((one) => one * data.arrow), data.width);
        });
      }
      drawScales(draw, at, ratio);
    };

    const drawScales = (draw, at, ratio) => {
      draw.font = `${12 * ratio}px system-ui, sans-serif`;
      draw.fillStyle = draw.strokeStyle = color("--ink");
      draw.lineWidth = 1.2 * ratio;
      draw.textBaseline = "middle";
      let y = 16 * ratio;
      const metres = niceStep(0.6 * at.width / at.scale, 4) / 2;
      let x = 12 * ratio;
      draw.beginPath();
      draw.moveTo(x, y); draw.lineTo(x + at.scale * metres, y);
      for (const end of [x, x + at.scale * metres]) { draw.moveTo(end, y - 4 * ratio); draw.lineTo(end, y + 4 * ratio); }
      draw.stroke();
      x += at.scale * metres + 6 * ratio;
      const length = metres < 1 ? `${format(1e3 * metres)} mm` : `${format(metres)} m`;
      draw.fillText(length, x, y);
      x += draw.measureText(length).width + 18 * ratio;
      for (const group of data.arrow > 0 ? data.forces.filter((one) => one.shown()) : []) {
        // A force whose arrow is some 40 pixels long at this zoom.
        const force = niceStep(100 * ratio / (at.scale * data.arrow), 1) / 2;
        const text = `${group.label} ${format(force)} N`, long = at.scale * force * data.arrow + 6 * ratio;
        if (x + long + draw.measureText(text).width > at.width) { x = 12 * ratio; y += 20 * ratio; }
        draw.fillStyle = data.colors[theme()][group.kind];
        arrow(draw, { x, y, scale: at.scale }, [0, 0], [force * data.arrow, 0], Math.min(data.width, 7 * ratio / at.scale));
        x += long;
        draw.fillStyle = color("--ink");
        draw.fillText(text, x, y);
        x += draw.measureText(text).width + 18 * ratio;
      }
    };

    // --- plots: the series of the scene, and the forces of the selected body
    const magnitude = (group, k) => (row) => Math.hypot(group.vectors.at(2 * k, row, 0), group.vectors.at(2 * k + 1, row, 0));
    const forcesOf = (body) => data.forces.flatMap((group) => group.bodies.flatMap((one, k) =>
      one === body ? [{ name: group.names[k], unit: "N", at: magnitude(group, k) }] : []));
    const curves = () => [
      ...(state.selected >= 0 ? forcesOf(state.selected) : []).slice(0, 4),
      ...data.series.names.map((name, k) => ({ name, unit: data.series.units[k], at: (row) => series.at(k, row, 0) })),
    ].slice(0, 6);
    const COLORS = ["--c1", "--c2", "--c3", "--c4", "--c5", "--c6"];
    let still = null, margin = 0;
    const drawCurves = () => {
      const [width, height, ratio] = size(chart);
      still = document.createElement("canvas");
      still.width = width; still.height = height;
      const draw = still.getContext("2d"), lines = curves();
      margin = 66 * ratio; // of labels such as 15000
      const right = width - 10 * ratio, top = 10 * ratio, bottom = height - 24 * ratio;
      const [from, to] = state.span.map((time) => place(time)[0]);
      const columns = Math.max(1, Math.round((right - margin) / ratio));
      let low = 0, high = -Infinity;
      const drawn = lines.map((line) => {
        const lows = new Float64Array(columns).fill(Infinity), highs = new Float64Array(columns).fill(-Infinity);
        for (let row = from; row <= Math.min(to + 1, rows - 1); row++) {
          const value = line.at(row);
          const share = (times[row] - state.span[0]) / (state.span[1] - state.span[0]);
          const k = Math.min(columns - 1, Math.max(0, Math.floor(share * columns)));
          if (value < lows[k]) lows[k] = value;
          if (value > highs[k]) highs[k] = value;
          if (value < low) low = value;
          if (value > high) high = value;
        }
        return [lows, highs];
      });
      if (!(high > low)) high = low + 1;
      high += 0.05 * (high - low);
      const y = (value) => bottom - (value - low) / (high - low) * (bottom - top);
      const x = (time) => margin + (time - state.span[0]) / (state.span[1] - state.span[0]) * (right - margin);
      draw.font = `${11.5 * ratio}px system-ui, sans-serif`;
      draw.fillStyle = color("--dim");
      draw.strokeStyle = color("--line");
      draw.lineWidth = ratio;
      draw.textAlign = "right"; draw.textBaseline = "middle";
      const step = niceStep(high - low, 5);
      for (let value = Math.ceil(low / step) * step; value <= high; value += step) {
        draw.beginPath(); draw.moveTo(margin, y(value)); draw.lineTo(right, y(value)); draw.stroke();
        draw.fillText(format(value), margin - 6 * ratio, y(value));
      }
      draw.textAlign = "center"; draw.textBaseline = "top";
      const tick = niceStep(state.span[1] - state.span[0], Math.max(2, width / ratio / 110));
      for (let time = Math.ceil(state.span[0] / tick) * tick; time <= state.span[1] * (1 + 1e-12); time += tick)
        draw.fillText(`${format(1e3 * time, 5)} ms`, Math.min(x(time), right - 20 * ratio), bottom + 6 * ratio);
      draw.save(); draw.translate(12 * ratio, (top + bottom) / 2); draw.rotate(-Math.PI / 2);
      draw.fillText(`[${lines.length ? lines[0].unit : ""}]`, 0, -6 * ratio); draw.restore();
      lines.forEach((line, k) => {
        draw.strokeStyle = color(COLORS[k]);
        draw.lineWidth = 1.2 * ratio;
        draw.beginPath();
        const [lows, highs] = drawn[k];
        let last = null;
        for (let column = 0; column < columns; column++) {
          let near = lows[column], far = highs[column];
          if (near > far) continue;
          // From the end nearer to the column before: a slope is no saw.
          if (last !== null && far - last < last - near) [near, far] = [far, near];
          const at = margin + (column + 0.5) / columns * (right - margin);
          if (last === null) draw.moveTo(at, y(near)); else draw.lineTo(at, y(near));
          draw.lineTo(at, y(far));
          last = far;
        }
        draw.stroke();
      });
      legend.replaceChildren(...lines.map((line, k) => element("span", {},
        element("i", { style: `background: var(${COLORS[k]})` }), `${line.name} [${line.unit}]`, element("b"))));
    };
    const drawChart = () => {
      const [width, height, ratio] = size(chart);
      if (!still || still.width !== width || still.height !== height) drawCurves();
      const draw = chart.getContext("2d"), right = width - 10 * ratio;
      draw.clearRect(0, 0, width, height);
      draw.drawImage(still, 0, 0);
      const share = (state.time - state.span[0]) / (state.span[1] - state.span[0]);
      if (share >= 0 && share <= 1) {
        draw.strokeStyle = color("--accent");
        draw.lineWidth = 1.5 * ratio;
        const x = margin + share * (right - margin);
        draw.beginPath(); draw.moveTo(x, 8 * ratio); draw.lineTo(x, height - 24 * ratio); draw.stroke();
      }
      const [row] = place(state.time), lines = curves();
      legend.querySelectorAll("b").forEach((cell, k) => { if (lines[k]) cell.textContent = ` ${format(lines[k].at(row))}`; });
    };

    const tell = () => {
      const body = state.hovered >= 0 ? state.hovered : state.selected;
      if (body < 0) { told.textContent = "Point at a body, such as a link, for its values; select it to plot its forces."; return; }
      const [row, share] = place(state.time), [x, y, angle] = pose(body, row, share);
      const other = row + 1 < rows ? row + 1 : row - 1, step = times[other] - times[row];
      const here = pose(body, row, 0), there = other >= 0 ? pose(body, other, 0) : here;
      const rate = step ? here.map((value, k) => (there[k] - value) / step) : [0, 0, 0];
      const lines = [`${names[body].replace("_", " ")}: x ${format(1e3 * x, 4)} mm, y ${format(1e3 * y, 4)} mm, angle ${format(angle, 4)} rad`,
        `speed ${format(Math.hypot(rate[0], rate[1]))} m/s, ${format(rate[2])} rad/s`];
      const forces = forcesOf(body).map((one) => `${one.name} ${format(one.at(row))} N`);
      told.textContent = [...lines, forces.slice(0, 6).join(", ")].join("\n");
    };

    // --- time passes
    let wanted = false, last = 0;
    const redraw = (curvesToo = false) => {
      if (curvesToo) still = null;
      if (wanted) return;
      wanted = true;
      requestAnimationFrame(frame);
    };
    const frame = (now) => {
      wanted = false;
      if (state.playing) {
        state.time += Math.min(now - last, 100) / 1e3 / state.slow;
        if (state.time > times[rows - 1]) state.time = times[0];
        last = now;
        redraw();
      }
      if (!root.clientWidth) return;  // hidden, as on paper: a canvas has no pixels; the observer draws when it is shown
      slider.value = place(state.time)[0];
      readout.textContent = `${(1e3 * state.time).toFixed(2)} ms`;
      drawStage();
      drawChart();
      tell();
    };
    const goTo = (time) => { state.time = Math.min(Math.max(time, times[0]), times[rows - 1]); redraw(); };
    const setPlaying = (playing) => {
      state.playing = playing;
      play.textContent = playing ? "❚❚" : "▶";
      play.setAttribute("aria-label", playing ? "pause" : "play");
      last = performance.now();
      redraw();
    };
    const setSpeed = (change) => {
      const k = Math.min(speed.length - 1, Math.max(0, speed.selectedIndex + change));
      speed.selectedIndex = k;
      state.slow = Number(speed.value);
    };

    // --- pointer, wheel, keys
    const zoom = (factor, px, py) => {
      const at = window_(), ratio = window.devicePixelRatio || 1, view = state.view;
      const dx = ((px ?? at.cx / ratio) * ratio - at.cx) / at.scale;
      const dy = (at.cy - (py ?? at.cy / ratio) * ratio) / at.scale;
      const kept = Math.min(Math.max(factor, 1e-3 * data.view.width / view.width), 20 * data.view.width / view.width);
      view.x += dx * (1 - kept); view.y += dy * (1 - kept);
      view.width *= kept; view.height *= kept;
      redraw();
    };
    const fitView = () => {
      Object.assign(state.view, state.follow < 0 ? data.whole : { x: 0, y: 0, width: data.close, height: 0.6 * data.close });
      redraw();
    };
    const hit = (event) => {
      const at = window_(), draw = stage.getContext("2d"), ratio = window.devicePixelRatio || 1;
      let found = -1;
      for (const shape of shapes.filter((one) => one.solid))
        for (const body of shape.bodies) {
          into(draw, at, pose(body, at.row, at.share));
          if (draw.isPointInPath(shape.path, event.offsetX * ratio, event.offsetY * ratio)) found = body;
        }
      draw.setTransform(1, 0, 0, 1, 0, 0);
      return found;
    };
    const pointers = new Map();
    let moved = 0;
    stage.addEventListener("pointerdown", (event) => {
      stage.setPointerCapture(event.pointerId);
      pointers.set(event.pointerId, [event.offsetX, event.offsetY]);
      moved = 0;
    });
    stage.addEventListener("pointermove", (event) => {
      const before = pointers.get(event.pointerId);
      if (!before) {
        const body = hit(event);
        if (body !== state.hovered) { state.hovered = body; redraw(); }
        return;
      }
      const here = [event.offsetX, event.offsetY];
      const others = [...pointers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
      moved += Math.hypot(here[0] - before[0], here[1] - before[1]);
      if (others.length) {
        const apart = (at) => Math.hypot(at[0] - others[0][0], at[1] - others[0][1]) || 1;
        zoom(apart(before) / apart(here), (here[0] + others[0][0]) / 2, (here[1] + others[0][1]) / 2);
      } else {
        const ratio = window.devicePixelRatio || 1, { scale } = window_();
        state.view.x -= (here[0] - before[0]) * ratio / scale;
        state.view.y += (here[1] - before[1]) * ratio / scale;
        redraw();
      }
      pointers.set(event.pointerId, here);
    });
    const released = (event) => {
      if (pointers.delete(event.pointerId) && moved < 5 && event.type === "pointerup") {
        state.selected = hit(event);
        redraw(true);
      }
    };
    stage.addEventListener("pointerup", released);
    stage.addEventListener("pointercancel", released);
    stage.addEventListener("pointerleave", () => { state.hovered = -1; redraw(); });
    stage.addEventListener("wheel", (event) => {
      event.preventDefault();
      zoom(Math.exp(0.0015 * event.deltaY), event.offsetX, event.offsetY);
    }, { passive: false });
    const timeAt = (event) => {
      const ratio = window.devicePixelRatio || 1, right = chart.clientWidth - 10, left = margin / ratio;
      return state.span[0] + (event.offsetX - left) / (right - left) * (state.span[1] - state.span[0]);
    };
    chart.addEventListener("pointerdown", (event) => { chart.setPointerCapture(event.pointerId); goTo(timeAt(event)); });
    chart.addEventListener("pointermove", (event) => { if (event.buttons) goTo(timeAt(event)); });
    chart.addEventListener("wheel", (event) => {
      event.preventDefault();
      const factor = Math.exp(0.0015 * event.deltaY), middle = timeAt(event);
      const whole = [times[0], times[rows - 1]], least = 10 * (whole[1] - whole[0]) / rows;
      const span = [0, 1].map((k) => middle + factor * (state.span[k] - middle));
      if (span[1] - span[0] > least) state.span = [Math.max(span[0], whole[0]), Math.min(span[1], whole[1])];
      redraw(true);
    }, { passive: false });
    chart.addEventListener("dblclick", () => { state.span = [times[0], times[rows - 1]]; redraw(true); });
    root.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const own = event.target === stage || event.target === chart;
      const step = (sign) => {
        const [row] = place(state.time + 1e-12);
        goTo(times[Math.min(rows - 1, Math.max(0, row + sign * (event.shiftKey ? Math.ceil(rows / 100) : 1)))]);
      };
      const actions = { " ": () => setPlaying(!state.playing), ArrowLeft: () => step(-1), ArrowRight: () => step(1),
        ArrowUp: () => setSpeed(-1), ArrowDown: () => setSpeed(1), Home: () => goTo(times[0]), End: () => goTo(times[rows - 1]),
        "+": () => zoom(0.8), "=": () => zoom(0.8), "-": () => zoom(1.25), 0: fitView };
      if (own && actions[event.key]) { event.preventDefault(); actions[event.key](); }
    });
    play.addEventListener("click", () => setPlaying(!state.playing));
    slider.addEventListener("input", () => goTo(times[Number(slider.value)]));
    speed.addEventListener("change", () => { state.slow = Number(speed.value); });
    camera.addEventListener("change", () => { state.follow = Number(camera.value); fitView(); });
    fit.addEventListener("click", fitView);
    for (const label of switches) label.addEventListener("change", () => redraw());
    new ResizeObserver(() => redraw(true)).observe(root);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => redraw(true));
    new MutationObserver(() => redraw(true)).observe(document.documentElement, { attributes: true, attributeFilter: ["data-theme"] });
    // Paper is white. The theme that was shown is kept once for all players.
    const html = document.documentElement;
    addEventListener("beforeprint", () => {
      html.shownTheme ??= html.dataset.theme ?? "";
      html.dataset.theme = "light";
      still = null;
      drawStage(); drawChart();
    });
    addEventListener("afterprint", () => {
      if (html.shownTheme) html.dataset.theme = html.shownTheme;
      else if (html.shownTheme === "") delete html.dataset.theme;
      delete html.shownTheme;
    });
    redraw(true);
    root.dataset.ready = "true";
    root.player = state; // for those who look in from outside
  }

  document.head.append(element("style", {}, STYLE));
  for (const root of document.querySelectorAll("div.player")) {
    if (root.built) continue;
    root.built = true; // no attribute: a page that a browser has saved is built anew
    root.replaceChildren(root.querySelector("script"));
    player(root).catch((error) => {
      root.append(element("p", {}, `The player cannot start (${error.message}); it needs a browser of 2023 or later.`));
      console.error(error);
    });
  }
})();
