// Numbers as people read them.

const MINUS = "\u2212";

function sign(text) {
  return text.replace(/-/g, MINUS);
}

// `digits` significant digits; a power of ten where the number is very large or small.
export function significant(x, digits) {
  if (!Number.isFinite(x)) return "\u2013";
  if (x === 0) return "0";
  const size = Math.floor(Math.log10(Math.abs(x)));
  if (size < -4 || size > 6) {
    const [mantissa, exponent] = x.toExponential(digits - 1).split("e");
    return sign(`${mantissa}\u00d710${superscript(Number(exponent))}`);
  }
  return sign(x.toFixed(Math.max(0, digits - 1 - size)));
}

function superscript(n) {
  const digits = "\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079";
  const text = [...String(Math.abs(n))].map((d) => digits[d]).join("");
  return n < 0 ? `\u207b${text}` : text;
}

// A value with as many decimals as its standard error has meaning: two of the error's digits.
export function measured(value, error) {
  if (!(error > 0) || !Number.isFinite(error)) return significant(value, 5);
  const size = Math.floor(Math.log10(error));
  if (Math.abs(value) >= 1e6 || (value !== 0 && Math.abs(value) < 1e-4)) return significant(value, 4);
  return sign(value.toFixed(Math.min(8, Math.max(0, 1 - size))));
}

// Three digits with a prefix of the SI.
export function metric(x) {
  for (const [scale, prefix] of [[1e12, "T"], [1e9, "G"], [1e6, "M"], [1e3, "k"]]) {
    if (Math.abs(x) >= scale) return `${(x / scale).toFixed(x / scale >= 100 ? 0 : x / scale >= 10 ? 1 : 2)} ${prefix}`;
  }
  return String(Math.round(x));
}

export function grouped(n) {
  return n.toLocaleString("en-US");
}

export function plural(n, noun) {
  return `${grouped(n)} ${noun}${n === 1 ? "" : "s"}`;
}

export function duration(seconds) {
  const s = Math.max(0, Math.round(seconds));
  if (s < 60) return `${s} s`;
  if (s < 3600) return `${Math.floor(s / 60)} min ${s % 60} s`;
  return `${Math.floor(s / 3600)} h ${Math.floor((s % 3600) / 60)} min`;
}
