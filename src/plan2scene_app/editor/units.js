// Reads and writes lengths in metres, or in feet and inches. The document is in metres.

const FOOT = 0.3048;

export function lengthText(metres, feet) {
  if (!feet) return `${metres.toFixed(2)} m`;
  const inches = Math.round(Math.abs(metres) / (FOOT / 12));
  return `${metres < 0 ? "-" : ""}${Math.floor(inches / 12)}' ${inches % 12}"`;
}

export const areaText = (area, feet) => (feet ? `${(area / FOOT / FOOT).toFixed(0)} sq ft` : `${area.toFixed(1)} m\u00b2`);

/** Metres of "3.2", "3,2 m", "320 cm", "3200 mm", "12' 6"", "12 ft 6 in"; NaN for anything else. */
export function readLength(text, feet) {
  const clean = text.trim().toLowerCase().replace(/,/g, ".").replace(/\u2032|\u2019/g, "'").replace(/\u2033|\u201d|''/g, '"');
  const imperial = clean.match(/^(?:(\d+(?:\.\d+)?)\s*(?:'|ft))?\s*(?:(\d+(?:\.\d+)?)\s*(?:"|in|$))?$/);
  if (imperial && /['"]|ft|in/.test(clean)) return (Number(imperial[1] ?? 0) + Number(imperial[2] ?? 0) / 12) * FOOT;
  const metric = clean.match(/^(\d+(?:\.\d*)?|\.\d+)\s*(mm|cm|m)?$/);
  if (!metric) return NaN;
  const unit = { mm: 0.001, cm: 0.01, m: 1 }[metric[2]] ?? (feet ? FOOT : 1);
  return Number(metric[1]) * unit;
}

/** The two lengths of "4.2 x 3"; null for anything else. */
export function readSize(text, feet) {
  const sides = text.split(/[x\u00d7*]/i).map((part) => readLength(part, feet));
  return sides.length === 2 && sides.every((v) => v > 0) ? sides : null;
}
