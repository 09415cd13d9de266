// What the server's answers hold, by name.

/** A run: its panels with their lines, and what the circuit needs of it. */
export function readRun(about, rows) {
  const [time, ...lines] = rows;
  const byPath = new Map();
  let i = 0;
  for (const panel of [...about.panels, ...about.live]) {
    for (const line of panel.lines) {
      line.y = lines[i++];
      byPath.set(line.path, { y: line.y, unit: panel.unit });
    }
  }
  const largest = (path) => byPath.get(path)?.y.reduce((most, one) => Math.max(most, Math.abs(one)), 0) ?? 0;
  const position = byPath.get("plant.position")?.y ?? new Float32Array([0, 1]);
  const stroke = about.machine.stroke;
  return {
    ...about, time, byPath,
    factors: Object.fromEntries(about.panels.map(({ title, factor }) => [title, factor])),
    reach: stroke ? [0, stroke * about.live[0].factor] : [Math.min(...extremes(position)), Math.max(...extremes(position))],
    largestPressure: Math.max(largest("plant.pressure_a"), largest("plant.pressure_b"), 1e-9),
    largestOpening: largest("valve.opening"),
    suppliedText: about.machine.supplied ? `${Number((about.machine.supplied / 1e5).toPrecision(3))} bar` : "",
  };
}

function extremes(values) {
  return values.reduce(([low, high], one) => [Math.min(low, one), Math.max(high, one)], [Infinity, -Infinity]);
}

/** A loop in frequency. */
export function readBode(about, rows) {
  const [frequency, ...curves] = rows;
  return { ...about, frequency, rows: curves };
}
