// What the server's answers hold, by name.

/** A run: its panels with their lines, and what the circuit needs of it. */
export function readRun(about, rows) {
  const [time, ...lines] = rows;
  const byPath = new Map();
  let i = 0;
  for (const panel of [...about.panels, ...about.live]) {
    for (const line of panel.lines) {
      line.y = lines[i++];
      byPath.set(line.path, { y: line.y, unit: panel.unit, extent: panel.extent });
    }
  }
  const largest = (path) => Math.max(0, ...(byPath.get(path)?.extent ?? []).map(Math.abs));
  const stroke = about.machine.stroke;
  return {
    ...about, time, byPath,
    reach: stroke ? [0, stroke * about.live[0].factor] : byPath.get("plant.position")?.extent ?? [0, 1],
    largestPressure: Math.max(largest("plant.pressure_a"), largest("plant.pressure_b"), 1e-9),
    largestOpening: largest("valve.opening"),
    suppliedText: about.machine.supplied ? `${Number((about.machine.supplied / 1e5).toPrecision(3))} bar` : "",
  };
}

/** A loop in frequency. */
export function readBode(about, rows) {
  const [frequency, ...curves] = rows;
  return { ...about, frequency, rows: curves };
}
