import {say, type Words} from "../messages/say";
import type {TrialSpread} from "../protocol/history_messages";
import {make, makeSvg} from "./elements";

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

const kLevels = [0, 25, 50, 75, 100];
/// More lines than these cannot be told apart.
const kMostOthers = 60;

/// A curve drawn for the available width.
export class Curve {
  readonly body = make("div.curve");
  private data: CurveData | undefined;

  constructor() {
    new ResizeObserver(() => this.draw()).observe(this.body);
  }

  show(data: CurveData): void {
    this.data = data;
    this.draw();
  }

  /// Highlights one of the other lines.
  light(key: number | undefined): void {
    for (const line of this.body.querySelectorAll<SVGElement>(".other"))
      line.classList.toggle("lit", line.dataset["key"] === String(key));
  }

  private draw(): void {
    const {data} = this;
    const width = this.body.clientWidth;
    // Hidden, it is drawn again when it is shown, in the language of that moment.
    if (!data || width === 0) return this.body.replaceChildren();
    const frame = new Frame(width, data);
    const svg = makeSvg("svg", {
      ...{role: "img", "aria-label": data.label},
      ...{width: String(width), height: String(frame.height)},
    });
    const add = (tag: "path" | "line" | "circle" | "rect", of: Attributes): SVGElement =>
      svg.appendChild(makeSvg(tag, textOf(of)));
    const line = (name: string, points: number, [x1, x2]: readonly [number, number]): void => {
      const level = frame.y(points);
      add("line", {class: name, x1, x2, y1: level, y2: level});
    };
    const path = (name: string, points: readonly CurvePoint[], end = ""): SVGElement =>
      add("path", {class: name, d: frame.path(points) + end});
    const {spread, pass, own, grade} = data;
    for (const points of kLevels) line("grid", points, frame.ends);
    frame.label(svg);
    const high = spread.map((at): CurvePoint => [at.n, at.high]);
    const low = spread.map((at): CurvePoint => [at.n, at.low]).reverse();
    if (spread.length > 0) path("band", [...high, ...low], "Z");
    for (const {key, points} of (data.others ?? []).slice(0, kMostOthers))
      path("other", points).dataset["key"] = String(key);
    if (spread.length > 0)
      path(
        "median",
        spread.map(({n, median}) => [n, median]),
      );
    if (pass !== null) line("pass", pass, frame.ends);
    if (grade) {
      const ends = [frame.x(grade.from) - 5, frame.x(grade.to) + 5] as const;
      const [x, width] = [ends[0], ends[1] - ends[0]];
      if (grade.low !== null && grade.high !== null) {
        const y = frame.y(grade.high);
        add("rect", {class: "interval", x, y, width, height: frame.y(grade.low) - y, rx: 3});
      }
      line("mean", grade.mean, ends);
    }
    path("own", own);
    for (const [n, points] of own)
      add("circle", {class: "dot", cx: frame.x(n), cy: frame.y(points), r: 4});
    this.body.replaceChildren(svg);
  }
}

type Attributes = Readonly<Record<string, string | number>>;
const textOf = (of: Attributes): Record<string, string> =>
  Object.fromEntries(
    Object.entries(of).map(([name, value]) => [
      name,
      typeof value === "number" ? String(Math.round(10 * value) / 10) : value,
    ]),
  );

/// Maps trials and points to positions within a width, in units of the page's letter size.
class Frame {
  private readonly rem = Number.parseFloat(getComputedStyle(document.documentElement).fontSize);
  readonly height = 14.5 * this.rem;
  readonly ends: readonly [number, number];
  private readonly last: number;

  constructor(width: number, {own, spread, others = []}: CurveData) {
    this.ends = [2.2 * this.rem, width - 0.8 * this.rem];
    const all = [...own, ...others.flatMap(({points}) => points)].map(([n]) => n);
    this.last = [...all, ...spread.map(({n}) => n)].reduce((most, n) => Math.max(most, n), 1);
  }

  x(n: number): number {
    const [left, right] = this.ends;
    // A single trial is centred.
    return left + (right - left) * (this.last === 1 ? 0.5 : (n - 1) / (this.last - 1));
  }
  y(points: number): number {
    return 0.7 * this.rem + (this.height - 2.4 * this.rem) * (1 - points / 100);
  }
  path(points: readonly CurvePoint[]): string {
    return points
      .map(
        ([n, value], i) =>
          `${i > 0 ? "L" : "M"}${this.x(n).toFixed(1)} ${this.y(value).toFixed(1)}`,
      )
      .join("");
  }

  label(svg: SVGSVGElement): void {
    const word = (text: number, of: Attributes): void => {
      svg.appendChild(makeSvg("text", textOf(of))).textContent = String(text);
    };
    const {rem} = this;
    const [left, right] = this.ends;
    for (const points of kLevels)
      word(points, {x: left - 0.5 * rem, y: this.y(points) + 0.28 * rem, "text-anchor": "end"});
    const step = Math.max(1, Math.ceil((1.8 * rem * (this.last - 1)) / (right - left)));
    for (let n = 1; n <= this.last; n += step)
      word(n, {x: this.x(n), y: this.height - 0.4 * rem, "text-anchor": "middle"});
  }
}

/// A legend of the curve's lines.
export function legend(...of: readonly (readonly [line: string, words: Words])[]): HTMLElement {
  return make(
    "ul.legend",
    ...of.map(([line, words]) =>
      make("li", make("span", {className: `key ${line}`}), make("span", words)),
    ),
  );
}

/// Bars of the points that each criterion costs.
export function lossBars(
  lost: readonly {readonly criterion: string; readonly points: number}[],
  of = "",
): HTMLElement {
  const worth = lost.filter(({points}) => points >= 0.5).slice(0, 5);
  const most = Math.max(...worth.map(({points}) => points), 1);
  const bars = worth.map(({criterion, points}) => {
    const bar = make("span.bar-of", make("span.fill"));
    bar.firstElementChild!.setAttribute("style", `width: ${(100 * points) / most}%`);
    const figure = say("history.lost", {points: Math.round(points)});
    return make("li", make("span.criterion", criterion), make("span.cost", figure), bar);
  });
  if (bars.length === 0) return make("p.quiet", say("history.no_loss"));
  return make("ol.losses", {ariaLabel: of}, ...bars);
}
