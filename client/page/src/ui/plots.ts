import uPlot from "uplot";

import {type Key, locale, say} from "../messages/say";
import {kFigures, kHistoryS, type Station} from "../model/station";
import {clock, figure} from "../model/words";
import {make, setText} from "./elements";

interface PlotKind {
  readonly title: Key;
  readonly unit: string;
  readonly colour: string; // name in the style sheet
  readonly least: number; // least range of the axis, so that noise does not fill it
}

/// In the order of kFigures.
const kKinds: Readonly<Record<(typeof kFigures)[number], PlotKind>> = {
  force: {title: "figure.force", unit: "N", colour: "force", least: 0.5},
  torque: {title: "figure.torque", unit: "mN·m", colour: "torque", least: 5},
  past: {title: "figure.past_long", unit: "mm", colour: "past", least: 0.5},
  step: {title: "figure.step", unit: "µs", colour: "step", least: 20},
};

/// The time axis of the plots: this page's time, ending now, or a recording's.
export interface PlotTime {
  readonly nowS: number;
  readonly isRecorded: boolean;
  readonly gaps: readonly {readonly fromS: number; readonly toS: number}[]; // not recorded
}

/// A colour of the style sheet as it is now.
export const colourOf = (name: string): string =>
  getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

/// How an axis looks.   @param size  in letters
export function axisIn(size: number): uPlot.Axis {
  const {fontFamily, fontSize} = getComputedStyle(document.body);
  const px = Math.max(11, 0.72 * Number.parseFloat(fontSize));
  const grid = {stroke: colourOf("line"), width: 1};
  const stroke = colourOf("quiet");
  return {
    stroke,
    font: `${px}px ${fontFamily}`,
    size: size * px,
    gap: 6,
    grid,
    ticks: {show: false},
  };
}

/// Live plots of one station, stacked, with a common time axis.
export class Plots {
  private plots: {plot: uPlot; value: HTMLOutputElement; unit: string; figure: number}[] = [];
  private time: PlotTime = {nowS: 0, isRecorded: false, gaps: []};
  private wanted: readonly (typeof kFigures)[number][] = kFigures;

  constructor(private readonly parent: HTMLElement) {
    this.build();
    new ResizeObserver(() => this.resize()).observe(parent);
  }

  /// A student needs only the force and the hand's distance past the surface.
  showFor(student: boolean): void {
    this.wanted = student ? ["force", "past"] : kFigures;
    this.build();
  }

  /// Builds them again, in the style sheet's present colours.
  build(): void {
    for (const {plot} of this.plots) plot.destroy();
    this.parent.replaceChildren();
    this.plots = this.wanted.map((name, i) => {
      const kind = kKinds[name];
      const isLast = i === this.wanted.length - 1;
      const value = make("output", {ariaLive: "off"}); // the announcer does that
      value.style.color = `var(--${kind.colour})`;
      const title = say(kind.title);
      const header = make("header", make("h3", title), value);
      const chart = make("div.chart", {role: "img"});
      chart.ariaLabel = say("figure.last_seconds", {figure: title, seconds: kHistoryS});
      this.parent.append(make("div", {className: isLast ? "plot last" : "plot"}, header, chart));
      const time = (): PlotTime => this.time;
      const plot = new uPlot(options(kind, chart, isLast, time), [[], []], chart);
      return {plot, value, unit: kind.unit, figure: kFigures.indexOf(name)};
    });
  }

  update(station: Station | undefined, time: PlotTime): void {
    if (this.parent.clientWidth === 0) return; // the panel is closed
    const wasRecorded = this.time.isRecorded;
    this.time = time;
    this.plots.forEach(({plot, value, unit, figure: i}) => {
      const [times, figures] = station?.history.series(i, time.nowS) ?? [[], []];
      plot.setData([times, figures]);
      // The axis moves along, while its range stays.
      if (wasRecorded || time.isRecorded) plot.redraw(false, true);
      const last = figures.at(-1);
      setText(value, last === undefined ? "–" : `${figure(last)} ${unit}`);
    });
  }

  private resize(): void {
    for (const {plot} of this.plots) {
      const {clientWidth: width, clientHeight: height} = plot.root.parentElement!;
      if (width > 0 && (width !== plot.width || height !== plot.height))
        plot.setSize({width, height});
    }
  }
}

/// Every five visible seconds of a recording, relative to now.
function fullSeconds(nowS: number): number[] {
  const seconds: number[] = [];
  for (let at = 5 * Math.ceil((nowS - kHistoryS) / 5); at <= nowS; at += 5) {
    if (at >= 0) seconds.push(at - nowS);
  }
  return seconds;
}

function shadeGaps(plot: uPlot, {nowS, gaps}: PlotTime, colour: string): void {
  const {left, top, width, height} = plot.bbox;
  for (const {fromS, toS} of gaps) {
    const from = Math.max(left, plot.valToPos(fromS - nowS, "x", true));
    const to = Math.min(left + width, plot.valToPos(toS - nowS, "x", true));
    if (to <= from) continue;
    plot.ctx.fillStyle = colour;
    plot.ctx.fillRect(from, top, to - from, height);
  }
}

function options(
  kind: PlotKind,
  chart: HTMLElement,
  isLast: boolean,
  time: () => PlotTime,
): uPlot.Options {
  const colour = colourOf(kind.colour);
  return {
    width: Math.max(1, chart.clientWidth),
    height: Math.max(1, chart.clientHeight),
    legend: {show: false},
    hooks: {drawClear: [(plot) => shadeGaps(plot, time(), colourOf("gap"))]},
    cursor: {show: false},
    padding: [6, 14, isLast ? 0 : 4, 0],
    scales: {
      x: {time: false, range: [-kHistoryS, 0]},
      y: {range: (_plot, _low, high) => [0, Math.max(kind.least, 1.12 * (high ?? 0))]},
    },
    axes: [
      {
        ...{...axisIn(1.8), show: isLast, gap: 2, grid: {show: false}},
        splits: () => (time().isRecorded ? fullSeconds(time().nowS) : [-10, -5, 0]),
        values: (_plot, splits) =>
          splits.map((split) =>
            time().isRecorded
              ? clock(split + time().nowS)
              : split === 0
                ? say("figure.now")
                : `${split} s`,
          ),
      },
      {
        ...{...axisIn(3.6), space: 26},
        values: (_plot, splits) => splits.map((split) => split.toLocaleString(locale())),
      },
    ],
    series: [
      {},
      {
        stroke: colour,
        width: 1.75,
        fill: `color-mix(in srgb, ${colour} 12%, transparent)`,
        // A single point, as after a seek of a paused replay, is no line.
        points: {show: (plot) => plot.data[0].length === 1, size: 6},
        // A pause of the data is drawn as a gap.
        gaps: (plot, _series, first, last) => {
          const times = plot.data[0];
          const gaps: uPlot.Series.Gaps = [];
          for (let i = first + 1; i <= last; i++) {
            if (times[i]! - times[i - 1]! < 0.5) continue;
            const from = Math.round(plot.valToPos(times[i - 1]!, "x", true));
            const to = Math.round(plot.valToPos(times[i]!, "x", true));
            gaps.push([from, to]);
          }
          return gaps;
        },
      },
    ],
  };
}
