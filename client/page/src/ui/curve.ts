import uPlot from "uplot";

import {say, type Words} from "../messages/say";
import type {TrialSpread} from "../protocol/history_messages";
import {make} from "./elements";
import {axisIn, colourOf} from "./plots";

export type CurvePoint = readonly [n: number, points: number];

/// Points by trial number.
export interface CurveData {
  readonly label: string; // for a screen reader
  readonly spread: readonly TrialSpread[]; // of the class
  readonly pass: number | null;
  readonly own: readonly CurvePoint[];
  /// Mean of the last trials and its interval, drawn over those trials.
  readonly grade?: {
    from: number;
    to: number;
    mean: number;
    low: number | null;
    high: number | null;
  };
  readonly others?: readonly {readonly key: number; readonly points: readonly CurvePoint[]}[];
}

/// More lines than these cannot be told apart.
const kMostOthers = 60;

/// Names of the lines' colours in the style sheet.
const kColours = {
  ...{own: "accent", interval: "force", band: "past", median: "past", other: "quiet"},
  pass: "quiet",
} as const;
export type Line = keyof typeof kColours;

/// A curve drawn for the available width.
export class Curve {
  readonly body = make("div.curve", {role: "img"});
  private data: CurveData | undefined;
  private plot: uPlot | undefined;

  constructor() {
    new ResizeObserver(() => this.draw()).observe(this.body);
  }

  show(data: CurveData): void {
    this.data = data;
    this.body.ariaLabel = data.label;
    this.draw();
  }

  /// Highlights one of the other lines.
  light(key: number | undefined): void {
    const at = this.data?.others?.findIndex((one) => one.key === key) ?? -1;
    this.plot?.setSeries(at < 0 ? null : kFirstOther + at, {focus: true});
  }

  private draw(): void {
    const {data} = this;
    const {clientWidth: width, clientHeight: height} = this.body;
    this.plot?.destroy();
    this.plot = undefined;
    if (!data || width === 0) return; // hidden, it is drawn when it is shown
    const {spread, pass, own, grade} = data;
    const others = (data.others ?? []).slice(0, kMostOthers);
    const all = [...own, ...others.flatMap(({points}) => points)].map(([n]) => n);
    const last = [...all, ...spread.map(({n}) => n)].reduce((most, n) => Math.max(most, n), 1);
    const trials = Array.from({length: last}, (_, i) => i + 1);
    const values = (points: readonly CurvePoint[]) => {
      const at = new Map(points);
      return trials.map((n) => at.get(n) ?? null);
    };
    const level = (points: number | null | undefined, from = 1, to = last) =>
      values(trials.filter((n) => from <= n && n <= to).map((n) => [n, points!]));
    const line = (of: Line, more: uPlot.Series = {}): uPlot.Series => ({
      ...{stroke: colourOf(kColours[of]), width: 2, spanGaps: true, points: {show: false}},
      ...more,
    });
    const edge = {points: {show: false}}; // of what is filled
    const drawn: [(number | null)[], uPlot.Series][] = [
      [values(spread.map(({n, high}) => [n, high])), edge],
      [values(spread.map(({n, low}) => [n, low])), edge],
      [level(grade?.high, grade?.from, grade?.to), edge],
      [level(grade?.low, grade?.from, grade?.to), edge],
      ...others.map(({points}): [(number | null)[], uPlot.Series] => [
        values(points),
        line("other", {width: 1}),
      ]),
      [values(spread.map(({n, median}) => [n, median])), line("median", {dash: [1, 5]})],
      [level(pass), line("pass", {dash: [7, 4]})],
      [level(grade?.mean, grade?.from, grade?.to), line("interval")],
      [values(own), line("own", {points: {show: true, size: 8, fill: colourOf("glow")}})],
    ];
    const fill = (of: Line): string =>
      `color-mix(in srgb, ${colourOf(kColours[of])} 22%, transparent)`;
    const options: uPlot.Options = {
      ...{width, height, cursor: {show: false}, legend: {show: false}, focus: {alpha: 0.25}},
      scales: {x: {time: false, range: last > 1 ? [1, last] : [0, 2]}, y: {range: [0, 100]}},
      axes: [
        {...axisIn(1.8), grid: {show: false}, incrs: [1, 2, 5, 10, 20, 50]},
        {...axisIn(2.4), splits: [0, 25, 50, 75, 100]},
      ],
      series: [{}, ...drawn.map(([, series]) => series)],
      bands: [
        {series: [1, 2], fill: fill("band")},
        {series: [3, 4], fill: fill("interval")},
      ],
    };
    this.plot = new uPlot(options, [trials, ...drawn.map(([points]) => points)], this.body);
  }
}
/// Of the series of uPlot, after the trials and the edges of what is filled.
const kFirstOther = 5;

/// A legend of the curve's lines.
export const legend = (...of: readonly (readonly [line: Line, words: Words])[]): HTMLElement =>
  make(
    "ul.legend",
    ...of.map(([line, words]) => {
      const key = make("span", {className: `key ${line}`});
      key.style.setProperty("--of", `var(--${kColours[line]})`);
      return make("li", key, make("span", words));
    }),
  );

/// Bars of the points that each criterion costs.
export function lossBars(
  lost: readonly {readonly criterion: string; readonly points: number}[],
  of = "",
): HTMLElement {
  const worth = lost.filter(({points}) => points >= 0.5).slice(0, 5);
  const most = Math.max(...worth.map(({points}) => points), 1);
  const bars = worth.map(({criterion, points}) => {
    const bar = make("span.fill");
    bar.style.width = `${(100 * points) / most}%`;
    const figure = say("history.lost", {points: Math.round(points)});
    return make(
      "li",
      make("span.criterion", criterion),
      make("span.cost", figure),
      make("span.bar-of", bar),
    );
  });
  if (bars.length === 0) return make("p.quiet", say("history.no_loss"));
  return make("ol.losses", {ariaLabel: of}, ...bars);
}
