// What the server's answers hold, by name.

/** A run: its panels with their lines, and what the circuit needs of it. */
export function readRun(about, rows) {
  const [time, ...lines] = rows;
  const byPath = new Map();
  let i = 0;
  for (const panel of [...about.panels, ...about.live]) {
    for (const line of panel.lines) {
      line.y = lines[i++];
      byPath.set(line.path, { y: line.y, unit: panel.unit, factor: panel.factor, extent: panel.extent });
    }
  }
  return { ...about, time, byPath };
}

/** A loop in frequency. */
export function readBode(about, rows) {
  const [frequency, ...curves] = rows;
  return { ...about, frequency, rows: curves };
}
