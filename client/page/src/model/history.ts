/// The last seconds of several figures sampled together, for plots: column 0 is time [s].
export class History {
  private readonly columns: number[][];

  constructor(
    figures: number,
    private readonly keepS: number,
  ) {
    this.columns = Array.from({length: figures + 1}, () => []);
  }

  push(timeS: number, ...figures: readonly number[]): void {
    const times = this.columns[0]!;
    const last = times.at(-1);
    if (last !== undefined && timeS <= last) return;
    times.push(timeS);
    figures.forEach((figure, i) => this.columns[i + 1]?.push(figure));
    let old = 0;
    while (times[old]! < timeS - this.keepS) old += 1;
    // In batches: removing the first entry at every sample would copy the array each time.
    if (old > 64) for (const column of this.columns) column.splice(0, old);
  }

  clear(): void {
    for (const column of this.columns) column.length = 0;
  }

  /// Returns times relative to `nowS` (at most 0), and figure `i`.
  series(i: number, nowS: number): [number[], number[]] {
    const times = this.columns[0]!;
    const first = times.findIndex((time) => time >= nowS - this.keepS);
    if (first < 0) return [[], []];
    return [times.slice(first).map((time) => time - nowS), this.columns[i + 1]!.slice(first)];
  }
}
