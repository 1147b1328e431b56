// The plots of the page: what is drawn, and what happens when the view changes.

(async () => {
  const byId = (id) => document.getElementById(id);
  const place = byId("plots"), tools = byId("tools");
  const root = document.documentElement;
  try {
    const scene = JSON.parse(byId("meta").textContent);
    const [data, library] = await Promise.all([unpacked("data"), unpacked("library")]);
    const script = document.createElement("script");
    script.textContent = new TextDecoder().decode(library);
    document.head.append(script);
    read(scene, data);
    show(scene);
    root.dataset.ready = "yes";
    root.dataset.readyAfter = String(Math.round(performance.now()));
  } catch (problem) {
    const told = document.createElement("p");
    told.className = "problem";
    told.textContent = `This browser cannot show the plots (${problem.message}). The tables hold all the same.`;
    place.append(told);
    root.dataset.ready = "no";
  }

  /** The bytes of a packed text; the text is let go. */
  async function unpacked(id) {
    const element = byId(id);
    const text = atob(element.textContent);
    element.remove();
    const bytes = new Uint8Array(text.length);
    for (let k = 0; k < text.length; k += 1) bytes[k] = text.charCodeAt(k);
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  }

  /** Gives tracks and planes their columns. */
  function read(scene, bytes) {
    let from = 0;
    const floats = (count) => {
      const turned = new Uint8Array(8 * count);
      for (let b = 0; b < 8; b += 1) {
        for (let k = 0; k < count; k += 1) turned[8 * k + b] = bytes[from + b * count + k];
      }
      from += 8 * count;
      return new Float64Array(turned.buffer);
    };
    const small = (count) => bytes.subarray(from, from += count);
    const pairs = (count, of) => Array.from({ length: count }, () => ({ lo: floats(of), hi: floats(of) }));
    for (const track of scene.tracks) {
      track.t0 = floats(track.cells);
      track.t1 = floats(track.cells);
      // Where no cell holds several samples, cells can be told by their number.
      track.numbered = track.t0.every((t, k) => t === track.t1[k]);
      track.bands = pairs(track.series, track.cells);
      track.marks = Array.from({ length: track.marks }, () => small(track.cells));
    }
    for (const plane of scene.planes) {
      plane.bounds = pairs(plane.axes.length, plane.boxes);
      plane.status = small(plane.boxes);
    }
  }

  function show(scene) {
    const dark = matchMedia("(prefers-color-scheme: dark)");
    let printing = false;
    const touch = matchMedia("(pointer: coarse)").matches;
    const figures = [];
    const whole = span(scene.tracks.filter((track) => track.cells));
    let view = whole && { ...whole };

    /** All times of these tracks. */
    function span(tracks) {
      if (!tracks.length) return null;
      const first = Math.min(...tracks.map((track) => track.t0[0]));
      const last = Math.max(scene.refuted ?? -Infinity, ...tracks.map((track) => track.t1[track.cells - 1]));
      return last > first ? { from: first, to: last } : { from: first - 0.5, to: first + 0.5 };
    }

    // [1/5] Colours.
    function colors() {
      const night = dark.matches && !printing;
      return {
        night,
        ink: night ? "#e8e8e8" : "#1a1a1a",
        soft: night ? "#a9afb6" : "#555555",
        grid: night ? "#2c3237" : "#e4e4e4",
        paper: night ? "#15181b" : "#ffffff",
        red: night ? "#ff7b8a" : "#a0001c",
        measured: night ? ["#4a5057", "#7b828a"] : ["#c9c9c9", "#8f8f8f"],
        since: night ? ["#1d4763", "#2f6a91"] : ["#bfddf0", "#8fc1e2"],
        count: night ? ["#5b7f99", "#7fa6c2"] : ["#7f8b99", "#3f4b59"],
        modes: night ? "#56b4e9" : "#0072b2",
        tiles: night
          ? { 0: "#1c3445", 1: "#c98a12", 2: "#22b58a", edge: "rgba(255,255,255,0.25)" }
          : { 0: "#e3f2fb", 1: "#e69f00", 2: "#009e73", edge: "rgba(0,0,0,0.3)" },
        union: night ? { 1: "#2f6a91" } : { 1: "#9ccbe8" },
      };
    }
    const clear = (color, share) => {
      const part = (at) => parseInt(color.slice(at, at + 2), 16);
      return `rgba(${part(1)},${part(3)},${part(5)},${share})`;
    };
    /** Dark colours of the figures are too dark on a dark page. */
    const shown = (color, c) => (c.night && color === "#0072B2" ? "#56B4E9" : color);
    function style(layer, panel, c) {
      const color = shown(panel.color, c);
      switch (layer) {
        case "measured": return { fill: c.measured[0], line: c.measured[1], width: 1 };
        case "since": return { fill: c.since[0], line: c.since[1], width: 1 };
        case "trajectory": return { fill: clear(c.ink, 0.3), line: c.ink, width: 1 };
        case "count": return { fill: clear(c.count[0], 0.75), line: c.count[1], width: 1 };
        default: return { fill: clear(color, c.night ? 0.5 : 0.38), line: color, width: 1 };
      }
    }

    // Plotly reads texts as HTML.
    const plain = (text) => text.replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/>/g, "&gt;");
    const label = (it) => plain(it.unit ? `${it.name} [${it.unit}]` : it.name);
    const element = (tag, text, inside) => {
      const made = document.createElement(tag);
      if (text) made.textContent = text;
      if (inside) inside.append(made);
      return made;
    };
    const config = { displaylogo: false, responsive: false, doubleClick: false, scrollZoom: false,
      showTips: false, ...(touch ? { displayModeBar: false } : {}),
      modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"] };
    const widthOf = (div) => Math.max(240, printing ? 680 : div.clientWidth || place.clientWidth);

    function base(c, width, height, margin) {
      return {
        width, height, margin, paper_bgcolor: c.paper, plot_bgcolor: c.paper,
        font: { color: c.ink, size: 12, family: "system-ui, Noto Sans, sans-serif" },
        showlegend: false, dragmode: touch ? false : "zoom", hovermode: "x unified", hoversubplots: "axis",
        hoverlabel: { bgcolor: c.paper, bordercolor: c.soft, font: { color: c.ink, size: 12 } },
        modebar: { bgcolor: "rgba(0,0,0,0)", color: c.soft, activecolor: c.ink },
        shapes: [], annotations: [],
      };
    }
    function timeAxis(c, anchor) {
      return {
        range: [view.from, view.to], anchor, title: { text: `time [${plain(scene.time)}]`, standoff: 6 },
        gridcolor: c.grid, zeroline: false, linecolor: c.soft, showline: true, ticks: "outside", tickcolor: c.soft,
        hoverformat: ".10~g", unifiedhovertitle: { text: "%{x}" },
        showspikes: true, spikemode: "across", spikesnap: "cursor", spikethickness: 1, spikedash: "dot", spikecolor: c.soft,
      };
    }
    function refutedLine(c, layout) {
      if (scene.refuted === null) return;
      layout.shapes.push({ type: "line", xref: "x", yref: "paper", x0: scene.refuted, x1: scene.refuted, y0: 0, y1: 1,
        line: { color: c.red, width: 1.5 } });
    }
    const framed = (width) => ({ l: 74, r: 14, t: 26, b: 44, ...(width < 480 ? { l: 48, r: 6 } : {}) });

    // [2/5] Bands over time.
    const ROW = 150, GAP = 34;
    function bands(group, div, chosen) {
      const c = colors(), width = widthOf(div), margin = framed(width);
      const panels = group.panels.filter((_, at) => chosen.has(at));
      const inner = panels.length * ROW + (panels.length - 1) * GAP;
      const layout = base(c, width, inner + margin.t + margin.b, margin);
      const buckets = Math.max(50, Math.round(width - margin.l - margin.r));
      const seen = { ...view, buckets };
      const traces = [];
      panels.forEach((panel, at) => {
        const name = at ? `y${at + 1}` : "y";
        const drawn = panel.layers.map((layer) => [layer, slabs(scene.tracks[layer.track], layer.series, layer.between, seen)]);
        let known = panel.zero ? [0, 0] : null;
        if (panel.clash && view.from <= scene.refuted && scene.refuted <= view.to) {
          const ends = panel.clash.flat().filter(Number.isFinite);
          known = [Math.min(...ends), Math.max(...ends)];
        }
        for (const [, runs] of drawn) known = extent(runs, seen, known) || known;
        let [low, high] = known || [0, 1];
        const pad = (high - low) * 0.06 || Math.abs(low) * 1e-6 || 0.5;
        [low, high] = [panel.zero && low === 0 ? 0 : low - pad, high + pad];
        const top = 1 - at * (ROW + GAP) / inner;
        layout[at ? `yaxis${at + 1}` : "yaxis"] = {
          domain: [Math.max(0, top - ROW / inner), top], range: [low, high], fixedrange: true, anchor: "x",
          gridcolor: c.grid, zeroline: false, linecolor: c.soft, showline: true, nticks: 6, automargin: false,
          exponentformat: "power",
        };
        layout.annotations.push({ text: `<b>${label(panel)}</b>`, xref: "paper", x: 0, xanchor: "left", yref: `${name} domain`,
          y: 1, yanchor: "bottom", showarrow: false, font: { size: 12, color: c.ink } });
        for (const [layer, runs] of drawn) {
          const look = style(layer.style, panel, c);
          traces.push({ ...outline(runs, seen, [low, high]), yaxis: name, type: "scatter", mode: "lines", fill: "toself",
            fillcolor: look.fill, line: { color: look.line, width: look.width, simplify: false }, hoverinfo: "skip" });
        }
        const shape = (x0, x1, y0, y1, line) => layout.shapes.push({ type: "line", xref: "x", yref: name, x0, x1, y0, y1, line });
        const across = (y, line) => { if (y >= low && y <= high) shape(view.from, view.to, y, y, line); };
        if (panel.prior) for (const end of panel.prior.ends) if (end !== null) across(end, { color: c.ink, width: 1.3, dash: "dot" });
        if (panel.line !== null) across(panel.line, { color: c.ink, width: 1, dash: "dash" });
        if (panel.resets !== null) traces.push(resets(panel, name, [low, high], seen, c));
        if (panel.clash) {
          const half = (view.to - view.from) / 150;
          panel.clash.forEach(([lo, hi], which) => layout.shapes.push({
            type: "rect", xref: "x", yref: name, x0: scene.refuted - half, x1: scene.refuted + half,
            y0: Math.max(lo, low - 1e3 * (high - low)), y1: Math.min(hi, high + 1e3 * (high - low)),
            line: { color: which ? c.measured[1] : c.red, width: 1 }, fillcolor: which ? c.measured[0] : clear(c.red, 0.45) }));
        }
        traces.push(hover(panel, name, drawn, [low, high], seen, shown(panel.color, c)));
      });
      layout.xaxis = timeAxis(c, panels.length > 1 ? `y${panels.length}` : "y");
      refutedLine(c, layout);
      return Plotly.react(div, traces, layout, config);
    }

    function resets(panel, name, [low, high], seen, c) {
      const x = [], y = [];
      for (const [l, r] of stretches(scene.tracks[panel.layers[0].track], panel.resets, (mark) => mark !== 0, false, seen)) {
        const t = view.from + (l + r) / 2 * (view.to - view.from) / seen.buckets;
        x.push(t, t, null);
        y.push(low, low + (high - low) * 0.08, null);
      }
      return { x, y, yaxis: name, type: "scatter", mode: "lines", line: { color: c.ink, width: 1.2 }, hoverinfo: "skip" };
    }

    /** Points that are not seen and carry what is told of a column: bounds, and of how many samples. */
    function hover(panel, name, drawn, [low, high], seen, color) {
      const columns = new Map();
      const width = (view.to - view.from) / seen.buckets;
      for (const [layer, runs] of drawn) {
        if (!layer.says) continue;
        const track = scene.tracks[layer.track];
        for (const run of runs) {
          for (const slab of run) {
            if (slab.r <= 0 || slab.l >= seen.buckets) continue;
            const single = slab.n === 1 && layer.between !== "steps";
            const t = single ? track.t0[slab.k] : view.from + (slab.l + slab.r) / 2 * width;
            if (t < view.from || t > view.to) continue;
            const key = single ? t : Math.round((t - view.from) / width);
            let told = columns.get(key);
            if (!told) columns.set(key, told = { t, parts: [], y: 0 });
            const many = slab.n > 1 ? ` (${slab.n} samples)` : "";
            if (single && track.numbered && !told.sample) told.sample = slab.k + 1;
            const unit = panel.unit ? ` ${panel.unit}` : "";
            const word = layer.says === "proved" || layer.style === "count" ? "" : `${layer.says} `;
            told.parts.unshift(`${word}${bounds(slab.lo, slab.hi, panel.prior)}${unit}${many}`);
            const [lo, hi] = [Math.max(slab.lo, low), Math.min(slab.hi, high)];
            told.y = lo / 2 + hi / 2;
          }
        }
      }
      const all = [...columns.values()].sort((a, b) => a.t - b.t);
      return {
        x: all.map((told) => told.t), y: all.map((told) => told.y), yaxis: name, type: "scatter", mode: "markers",
        marker: { size: 4, color, opacity: 0 }, text: all.map((told) => `<b>${plain(panel.name)}</b> ${plain(told.parts.join(", "))}${told.sample ? `, sample ${told.sample}` : ""}`),
        hovertemplate: "%{text}<extra></extra>",
      };
    }

    // [3/5] The mode strip.
    function strip(modes, div) {
      const c = colors(), width = widthOf(div), margin = framed(width);
      const longest = Math.max(...modes.names.map((name) => name.length));
      margin.l = Math.min(width * 0.4, Math.max(margin.l, 14 + 7 * longest));
      const row = modes.names.length > 24 ? 13 : 26;
      const layout = base(c, width, modes.names.length * row + margin.t + margin.b, margin);
      layout.hovermode = false;
      const seen = { ...view, buckets: Math.max(50, Math.round(width - margin.l - margin.r)) };
      const step = (view.to - view.from) / seen.buckets;
      const bars = (at, claim, everywhere, look) => {
        const x = [], y = [];
        for (const [l, r] of stretches(scene.tracks[modes.track], at, claim, everywhere, seen)) {
          const [left, right] = [view.from + l * step, view.from + r * step];
          x.push(left, right, right, left, left, null);
          y.push(at - 0.3, at - 0.3, at + 0.3, at + 0.3, at - 0.3, null);
        }
        return { x, y, type: "scatter", mode: "lines", fill: "toself", hoverinfo: "skip",
          line: { color: c.modes, width: 0.5, simplify: false }, ...look };
      };
      const light = { fillpattern: { shape: "/", size: 6, solidity: 0.35, fgcolor: c.modes, bgcolor: clear(c.modes, 0.15) } };
      const traces = modes.names.flatMap((_, at) => [
        bars(at, (mark) => (mark & 1) !== 0, false, light),
        bars(at, (mark) => mark === 1, true, { fillcolor: c.modes }),
      ]);
      layout.xaxis = { ...timeAxis(c, "y"), showspikes: false };
      layout.yaxis = { range: [modes.names.length - 0.5, -0.5], fixedrange: true, showgrid: false, zeroline: false,
        tickvals: modes.names.map((_, at) => at), ticktext: modes.names.map(plain), tickfont: { size: row > 20 ? 12 : 9 }, linecolor: c.soft, showline: true };
      refutedLine(c, layout);
      return Plotly.react(div, traces, layout, config);
    }

    // [4/5] Boxes in two dimensions.
    function plane(shape, div, pair, frame) {
      const c = colors(), width = widthOf(div), margin = { ...framed(width), l: 70, t: 14, b: 50 };
      const height = Math.round(Math.min(460, Math.max(280, width * 0.62)));
      const layout = base(c, width, height, margin);
      const [i, j] = pair;
      const over = (at) => {
        const prior = shape.axes[at].prior;
        return frame.whole && prior[0] !== null && prior[1] > prior[0] ? padded(prior, 0.02) : padded(hullOf(shape.bounds[at]), 0.06);
      };
      const range = { x: frame.x || over(i), y: frame.y || over(j) };
      const size = [width - margin.l - margin.r, height - margin.t - margin.b].map((v) => Math.round(v * (devicePixelRatio || 1)));
      layout.hovermode = false;
      layout.images = [{ source: painted(shape, pair, range, size, c[shape.look]), xref: "x", yref: "y", x: range.x[0], y: range.y[1],
        sizex: range.x[1] - range.x[0], sizey: range.y[1] - range.y[0], sizing: "stretch", layer: "below" }];
      const axis = (at, over) => ({ range: over, title: { text: label(shape.axes[at]), standoff: 6 }, showgrid: false,
        zeroline: false, linecolor: c.soft, showline: true, ticks: "outside", tickcolor: c.soft, nticks: 7 });
      layout.xaxis = axis(i, range.x);
      layout.yaxis = axis(j, range.y);
      // Plotly shows axes only where there is a trace.
      const corners = { x: range.x, y: range.y, type: "scatter", mode: "markers", marker: { opacity: 0 }, hoverinfo: "skip" };
      return Plotly.react(div, [corners], layout, config);
    }
    const padded = ([low, high], share) => [low - share * (high - low), high + share * (high - low)];

    // [5/5] What is on the page, and what the user does.
    function figure(title, draw, isTime) {
      const holder = element("section", "", place);
      element("h2", title, holder);
      const div = element("div", "");
      div.className = "plot";
      // A place of its own until it is drawn, so that the page does not jump.
      div.style.minHeight = "160px";
      const entry = { div, isTime, stale: true, near: false, draw: () => { entry.stale = false; return draw(div); } };
      figures.push(entry);
      return { holder, div, entry };
    }
    function refresh(entry) {
      if (entry.near || printing) entry.draw(); else entry.stale = true;
    }
    function legendOf(items, holder) {
      if (!items.length) return;
      const line = element("p", "", holder);
      line.className = "legend";
      for (const [look, words] of items) {
        const item = element("span", "", line);
        const mark = element("i", "", item);
        mark.dataset.look = look;
        item.append(words);
      }
    }
    function dress() {
      const c = colors();
      for (const mark of place.querySelectorAll(".legend i")) {
        const kind = mark.dataset.look;
        if (/^(tiles|union)/.test(kind)) mark.style.background = c[kind.slice(0, 5)][kind.slice(5)];
        else if (kind === "prior") mark.style.cssText = `border-top: 2px dotted ${c.ink}; height: 0; vertical-align: 0.25rem`;
        else if (kind === "reset") mark.style.cssText = `border-left: 2px solid ${c.ink}; width: 0; margin-right: 0.5rem`;
        else if (kind === "alone") mark.style.background = c.modes;
        else if (kind === "possible") mark.style.background = `repeating-linear-gradient(135deg, ${c.modes} 0 2px, ${clear(c.modes, 0.15)} 2px 5px)`;
        else if (kind === "never") mark.style.borderColor = c.soft;
        else {
          const look = style(kind, { color: "#0072B2" }, c);
          mark.style.background = look.fill;
          mark.style.borderColor = look.line;
        }
      }
    }

    const MANY = 8;
    const work = scene.groups.filter((group) => group.id === "work");
    scene.groups.filter((group) => group.id !== "work").forEach(panels);
    for (const modes of scene.modes) {
      const { holder, div } = figure(modes.title, (at) => strip(modes, at), true);
      div.id = `plot-${modes.id}`;
      legendOf([["alone", "the only possible mode"], ["possible", "possible beside others"], ["never", "proved impossible"]], holder);
      holder.append(div);
    }
    work.forEach(panels);
    function panels(group) {
      const chosen = new Set(group.panels.map((_, at) => at).slice(0, MANY));
      const { holder, div, entry } = figure(group.title, (at) => bands(group, at, chosen), true);
      div.id = `plot-${group.id}`;
      if (group.note) element("p", group.note, holder);
      legendOf(group.legend, holder);
      if (group.panels.length > MANY) choose(group, chosen, holder, entry);
      holder.append(div);
    }
    function choose(group, chosen, holder, entry) {
      const fold = element("details", "", holder);
      element("summary", `${group.panels.length} in all: choose`, fold);
      const list = element("div", "", fold);
      list.className = "choice";
      group.panels.forEach((panel, at) => {
        const item = element("label", "", list);
        const box = element("input", "", item);
        box.type = "checkbox";
        box.checked = chosen.has(at);
        item.append(` ${panel.name}`);
        box.addEventListener("change", () => {
          if (box.checked) chosen.add(at); else chosen.delete(at);
          if (!chosen.size) { chosen.add(at); box.checked = true; }
          entry.draw();
        });
      });
    }
    for (const shape of scene.planes) {
      const pair = [...shape.first];
      const frame = {};
      const { holder, div, entry } = figure(shape.title, (at) => plane(shape, at, pair, frame), false);
      div.classList.add("plane");
      element("p", shape.note, holder);
      legendOf(shape.legend.map((words, at) => [`${shape.look}${at}`, words]).filter(([, words]) => words), holder);
      const line = element("p", "", holder);
      line.className = "choice";
      if (shape.axes.length > 2) {
        ["across", "up"].forEach((word, which) => {
          const item = element("label", `${word} `, line);
          const list = element("select", "", item);
          shape.axes.forEach((axis, at) => { element("option", axis.name, list).value = at; });
          list.value = pair[which];
          list.addEventListener("change", () => {
            pair[which] = Number(list.value);
            delete frame.x;
            delete frame.y;
            entry.draw();
          });
        });
      }
      if (shape.axes.some((axis) => axis.prior[0] !== null)) {
        const frames = (text, whole) => {
          const made = element("button", text, line);
          made.type = "button";
          made.addEventListener("click", () => {
            Object.assign(frame, { whole, x: undefined, y: undefined });
            entry.draw();
          });
        };
        frames("What is left", false);
        frames("Whole prior", true);
      }
      holder.append(div);
      entry.frame = frame;
    }

    function setView(from, to) {
      if (!(to > from)) return;
      const least = (whole.to - whole.from) * 1e-9;
      view = to - from < least ? view : { from, to };
      for (const entry of figures) if (entry.isTime) refresh(entry);
      tell();
    }
    /** What Plotly says of a changed view. */
    function listen(entry) {
      entry.div.on("plotly_relayout", (change) => {
        const ends = (axis) => change[`${axis}.range`] || (change[`${axis}.range[0]`] !== undefined
          ? [change[`${axis}.range[0]`], change[`${axis}.range[1]`]] : null);
        const all = change["xaxis.autorange"] || change["yaxis.autorange"];
        const x = ends("xaxis"), y = ends("yaxis");
        if (entry.isTime) {
          if (x) setView(x[0], x[1]); else if (all) setView(whole.from, whole.to);
        } else if (x || y || all) {
          if (all) { delete entry.frame.x; delete entry.frame.y; }
          if (x) entry.frame.x = x;
          if (y) entry.frame.y = y;
          entry.draw();
        }
      });
      entry.div.on("plotly_doubleclick", () => {
        if (entry.isTime) setView(whole.from, whole.to);
        else { delete entry.frame.x; delete entry.frame.y; entry.draw(); }
        return false;
      });
    }
    let tell = () => {};
    if (whole) {
      const button = (text, title, act) => {
        const made = element("button", text, tools);
        made.type = "button";
        made.title = title;
        made.setAttribute("aria-label", title);
        made.addEventListener("click", act);
      };
      const move = (share) => { const by = (view.to - view.from) * share; setView(view.from + by, view.to + by); };
      const zoom = (by) => { const [middle, half] = [(view.from + view.to) / 2, (view.to - view.from) / 2 * by]; setView(middle - half, middle + half); };
      button("All", "Show all times", () => setView(whole.from, whole.to));
      button("+", "Zoom in", () => zoom(0.5));
      button("−", "Zoom out", () => zoom(2));
      button("◀", "Earlier", () => move(-0.4));
      button("▶", "Later", () => move(0.4));
      if (scene.refuted !== null) {
        const near = 60 * (whole.to - whole.from) / Math.max(scene.tracks[0].cells, 60);
        button("Where it fails", "Show the time of the contradiction", () => setView(scene.refuted - near, scene.refuted + near / 3));
      }
      const told = element("output", "", tools);
      tell = () => { told.textContent = `${Number(view.from.toPrecision(7))} … ${Number(view.to.toPrecision(7))} ${scene.time}`; };
      tell();
    }
    dress();
    // What is in sight first: the others when they come near.
    const watch = new IntersectionObserver((seen) => {
      for (const one of seen) {
        const entry = figures.find((known) => known.div === one.target);
        entry.near = one.isIntersecting;
        if (entry.near && entry.stale) settle(entry);
      }
    }, { rootMargin: "300px" });
    function settle(entry) {
      const first = !entry.div.classList.contains("js-plotly-plot");
      entry.draw();
      entry.div.style.minHeight = "";
      if (first) listen(entry);
    }
    for (const entry of figures) watch.observe(entry.div);
    const redraw = () => { dress(); for (const entry of figures) refresh(entry); };
    dark.addEventListener("change", redraw);
    let width = place.clientWidth;
    new ResizeObserver(() => {
      if (printing || place.clientWidth === width) return;
      width = place.clientWidth;
      for (const entry of figures) refresh(entry);
    }).observe(place);
    const print = (begins) => {
      if (printing === begins) return;
      printing = begins;
      for (const fold of document.querySelectorAll("details")) {
        if (begins) { fold.dataset.was = fold.open ? "open" : ""; fold.open = true; } else fold.open = fold.dataset.was === "open";
      }
      dress();
      for (const entry of figures) { if (entry.stale || !entry.div.classList.contains("js-plotly-plot")) settle(entry); else entry.draw(); }
    };
    addEventListener("beforeprint", () => print(true));
    addEventListener("afterprint", () => print(false));
  }
})();
