// Bands over time, joined to the columns of a picture: what is drawn encloses what is given.
//
// Time is cut into buckets as wide as a column of pixels, and every cell is drawn over whole buckets. A bucket that
// two cells share has the hull of both; between separate cells the outline is straight.

/** The first cell that ends at or after `t`. */
function firstAfter(track, t) {
  let low = 0, high = track.cells;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (track.t1[middle] < t) low = middle + 1; else high = middle;
  }
  return low;
}

/** Runs of slabs {l, r, lo, hi, n} of a series in a view {from, to, buckets}; `n` counts the cells. */
function slabs(track, series, between, view) {
  const { lo, hi } = track.bands[series];
  const { t0, t1, cells } = track;
  const scale = view.buckets / (view.to - view.from);
  const bucket = (t) => Math.floor((t - view.from) * scale);
  const runs = [];
  let run = null;
  // One cell more on either side, so that the band goes on to the edges.
  const start = Math.max(0, firstAfter(track, view.from) - 1);
  for (let k = start; k < cells; k += 1) {
    if (lo[k] !== lo[k]) { run = null; continue; }
    const end = between === "holds" && k + 1 < cells ? t0[k + 1] : t1[k];
    let l = Math.max(bucket(t0[k]), -4 * view.buckets);
    const r = Math.min(bucket(end) + 1, 5 * view.buckets);
    if (!run) runs.push(run = []);
    const last = run[run.length - 1];
    if (last && l < last.r) {
      if (last.l === l || last.r === last.l + 1) {
        last.lo = Math.min(last.lo, lo[k]);
        last.hi = Math.max(last.hi, hi[k]);
        last.n += 1;
        l = last.r;
      } else {
        const cut = last.r;
        last.r = l;
        run.push({ l, r: cut, lo: Math.min(last.lo, lo[k]), hi: Math.max(last.hi, hi[k]), n: last.n + 1, k });
        l = cut;
      }
    }
    if (l < r) run.push({ l, r, lo: lo[k], hi: hi[k], n: 1, k });
    if (t0[k] > view.to) break;
  }
  if (between === "rare") {
    for (const lone of runs) {
      if (lone.length === 1 && lone[0].r - lone[0].l < 3) { lone[0].l -= 1; lone[0].r += 1; }
    }
  }
  return runs;
}

/** The hull of what is in view, as far as it is finite; null where nothing is. */
function extent(runs, view, known) {
  let [low, high] = known || [Infinity, -Infinity];
  for (const run of runs) {
    for (const slab of run) {
      if (slab.r < 0 || slab.l > view.buckets) continue;
      if (Number.isFinite(slab.lo)) low = Math.min(low, slab.lo);
      if (Number.isFinite(slab.hi)) high = Math.max(high, slab.hi);
    }
  }
  return low <= high ? [low, high] : null;
}

/** The outline as one list of corners, a gap between runs; unbounded ends reach out of `range`. */
function outline(runs, view, range) {
  const x = [], y = [];
  const width = (view.to - view.from) / view.buckets;
  const far = 10 * (range[1] - range[0]);
  const at = (bucket) => view.from + bucket * width;
  const top = (hi) => Math.min(hi, range[1] + far);
  const bottom = (lo) => Math.max(lo, range[0] - far);
  for (const run of runs) {
    if (x.length) { x.push(null); y.push(null); }
    const start = x.length;
    for (const slab of run) { x.push(at(slab.l), at(slab.r)); y.push(top(slab.hi), top(slab.hi)); }
    for (let k = run.length - 1; k >= 0; k -= 1) {
      x.push(at(run[k].r), at(run[k].l));
      y.push(bottom(run[k].lo), bottom(run[k].lo));
    }
    x.push(x[start]);
    y.push(y[start]);
  }
  return { x, y };
}

/** Stretches of buckets over which a claim holds; a cell speaks for the time since the one before. Where
    `everywhere`, the claim must hold of all cells that share a bucket, else of any. */
function stretches(track, mark, claim, everywhere, view) {
  const scale = view.buckets / (view.to - view.from);
  const held = new Uint8Array(view.buckets), denied = new Uint8Array(view.buckets);
  const marks = track.marks[mark];
  const start = firstAfter(track, view.from);
  for (let k = start; k < track.cells; k += 1) {
    const since = k > 0 ? track.t1[k - 1] : track.t0[k];
    const l = Math.max(0, Math.floor((since - view.from) * scale));
    const r = Math.min(view.buckets, Math.floor((track.t1[k] - view.from) * scale) + 1);
    (claim(marks[k]) ? held : denied).fill(1, Math.min(l, r), r);
    if (track.t1[k] > view.to) break;
  }
  const found = [];
  let begun = -1;
  for (let b = 0; b <= view.buckets; b += 1) {
    const holds = b < view.buckets && held[b] && !(everywhere && denied[b]);
    if (holds && begun < 0) begun = b;
    if (!holds && begun >= 0) { found.push([begun, b]); begun = -1; }
  }
  return found;
}
