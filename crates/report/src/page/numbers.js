"use strict";

// Numbers as text, rounded outward.

/** The decimal with `digits` significant digits that is next to `x` and not above it, or not below it where `up`.
    The long text is exact to more digits than any float that stands in a plot has. */
function rounded(x, digits, up) {
  if (!Number.isFinite(x)) return x > 0 ? "∞" : x < 0 ? "−∞" : "?";
  if (x === 0) return "0";
  const [mantissa, exponent] = Math.abs(x).toExponential(99).split("e");
  const all = mantissa.replace(".", "");
  let head = BigInt(all.slice(0, digits));
  const cut = /[1-9]/.test(all.slice(digits));
  if (cut && up === x > 0) head += 1n;
  return (x < 0 ? "-" : "") + placed(head.toString(), Number(exponent) - digits + 1);
}

/** Digits times a power of ten. */
function placed(digits, power) {
  const kept = digits.replace(/0+$/, "");
  power += digits.length - kept.length;
  const places = kept.length + power;
  if (places > 15 || places < -5) {
    const rest = kept.slice(1);
    return kept[0] + (rest ? "." + rest : "") + "e" + (places - 1);
  }
  if (power >= 0) return kept + "0".repeat(power);
  if (places > 0) return kept.slice(0, places) + "." + kept.slice(places);
  return "0." + "0".repeat(-places) + kept;
}

/** Bounds with as many digits as tell something of their width; ends of the prior as they were spelled. */
function bounds(lo, hi, prior) {
  const size = Math.max(Math.abs(lo), Math.abs(hi));
  let digits = 12;
  if (hi > lo && Number.isFinite(size)) {
    digits = Math.min(16, Math.max(3, Math.ceil(Math.log10(size / (hi - lo))) + 3));
  }
  const known = (x, end) => prior && prior.ends[end] === x && prior.spelled[end];
  const low = known(lo, 0) || rounded(lo, digits, false);
  const high = known(hi, 1) || rounded(hi, digits, true);
  return low === high ? low : `[${low}, ${high}]`;
}
