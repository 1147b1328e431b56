// Boxes in two of their dimensions, painted pixel by pixel: what may be true grows to whole pixels, what is certain
// shrinks to them.

/** Paints boxes into a picture of `width` times `height` pixels; gives its address. */
function painted(plane, [i, j], range, [width, height], colors) {
  const canvas = document.createElement("canvas");
  canvas.width = width;
  canvas.height = height;
  const pen = canvas.getContext("2d");
  const [x, y] = [plane.bounds[i], plane.bounds[j]];
  const near = (v, most) => Math.min(Math.max(v, -4), most + 4);
  const across = (v) => near((v - range.x[0]) / (range.x[1] - range.x[0]) * width, width);
  const down = (v) => near((range.y[1] - v) / (range.y[1] - range.y[0]) * height, height);
  if (plane.legend[0]) {
    // What no box covers of the prior is outside.
    pen.fillStyle = colors[0];
    const ends = ([low, high]) => [low ?? -Infinity, high ?? Infinity];
    const [low, high] = [ends(plane.axes[i].prior), ends(plane.axes[j].prior)];
    const [l, t] = [Math.ceil(across(low[0])), Math.ceil(down(high[1]))];
    pen.fillRect(l, t, Math.floor(across(low[1])) - l, Math.floor(down(high[0])) - t);
  }
  pen.fillStyle = colors[1];
  for (let k = 0; k < plane.boxes; k += 1) {
    const [l, t] = [Math.floor(across(x.lo[k])), Math.floor(down(y.hi[k]))];
    const [r, b] = [Math.ceil(across(x.hi[k])), Math.ceil(down(y.lo[k]))];
    pen.fillRect(l, t, Math.max(r - l, 1), Math.max(b - t, 1));
  }
  if (plane.legend[2]) {
    pen.fillStyle = colors[2];
    covered(plane, [x, y], [across, down], [width, height], (l, row, length) => pen.fillRect(l, row, length, 1));
  }
  if (plane.look === "tiles" && plane.boxes <= 4000) {
    pen.strokeStyle = colors.edge;
    pen.lineWidth = 1;
    for (let k = 0; k < plane.boxes; k += 1) {
      const [l, t, r, b] = [across(x.lo[k]), down(y.hi[k]), across(x.hi[k]), down(y.lo[k])];
      if (r - l > 3 && b - t > 3) pen.strokeRect(l, t, r - l, b - t);
    }
  }
  return canvas.toDataURL();
}

/** Tells the pixels that boxes which are proved inside cover wholly, together: seams between them are none. */
function covered(plane, [x, y], [across, down], [width, height], tell) {
  const inside = [];
  for (let k = 0; k < plane.boxes; k += 1) if (plane.status[k] === 2) inside.push(k);
  const edges = [...new Set(inside.flatMap((k) => [y.lo[k], y.hi[k]]))].sort((a, b) => b - a);
  const place = new Map(edges.map((edge, at) => [edge, at]));
  const strips = edges.slice(1).map(() => []);
  for (const k of inside) {
    for (let at = place.get(y.hi[k]); at < place.get(y.lo[k]); at += 1) strips[at].push(k);
  }
  const whole = new Uint8Array(width * height);
  // A row of pixels counts where every strip that it touches covers it, and strips touch one another.
  const rows = new Float64Array(height);
  const votes = new Uint16Array(width * height), voters = new Uint16Array(height);
  strips.forEach((boxes, at) => {
    const [top, bottom] = [down(edges[at]), down(edges[at + 1])];
    const [first, last] = [Math.max(0, Math.floor(top)), Math.min(height, Math.ceil(bottom))];
    if (first >= last) return;
    const bits = new Uint8Array(width);
    boxes.sort((a, b) => x.lo[a] - x.lo[b]);
    let end = -Infinity, start = 0;
    const close = () => {
      const [l, r] = [Math.max(0, Math.ceil(across(start))), Math.min(width, Math.floor(across(end)))];
      if (r > l) bits.fill(1, l, r);
    };
    for (const k of boxes) {
      if (x.lo[k] > end) {
        if (end > -Infinity) close();
        start = x.lo[k];
      }
      end = Math.max(end, x.hi[k]);
    }
    if (end > -Infinity) close();
    for (let row = first; row < last; row += 1) {
      rows[row] += Math.min(bottom, row + 1) - Math.max(top, row);
      voters[row] += 1;
      for (let c = 0; c < width; c += 1) votes[row * width + c] += bits[c];
    }
  });
  for (let row = 0; row < height; row += 1) {
    if (rows[row] < 1 - 1e-9) continue;
    for (let c = 0; c < width; c += 1) whole[row * width + c] = votes[row * width + c] === voters[row] ? 1 : 0;
  }
  for (let row = 0; row < height; row += 1) {
    let begun = -1;
    for (let c = 0; c <= width; c += 1) {
      const is = c < width && whole[row * width + c];
      if (is && begun < 0) begun = c;
      if (!is && begun >= 0) { tell(begun, row, c - begun); begun = -1; }
    }
  }
}

/** The hull of all boxes in one dimension, as far as it is finite. */
function hullOf(bounds) {
  let low = Infinity, high = -Infinity;
  for (let k = 0; k < bounds.lo.length; k += 1) {
    if (Number.isFinite(bounds.lo[k])) low = Math.min(low, bounds.lo[k]);
    if (Number.isFinite(bounds.hi[k])) high = Math.max(high, bounds.hi[k]);
  }
  if (low < high) return [low, high];
  return low === high ? [low - 0.5, high + 0.5] : [0, 1];
}
